#include "meshes.hpp"

#include <algorithm>
#include <coppice/scene/pose.hpp>

#include "accessor.hpp"
#include "surface.hpp"
#include "triangles.hpp"

namespace coppice::gltf {
namespace {

constexpr std::size_t most_triangles = std::size_t{1} << 26;
constexpr std::size_t most_vertices = std::size_t{1} << 26;
constexpr float largest_coordinate = 1e9f;

// How a node carries surfaces into its frame. Normals go by the cofactor matrix, which is det·M⁻ᵀ and exists
// where the node flattens its mesh, too.
struct SurfaceMap {
  glm::dmat4 points{1};
  glm::dmat3 vectors{1}, normals{1};
  double handedness = 1;

  explicit SurfaceMap(const glm::dmat4& to_frame) : points(to_frame), vectors(to_frame) {
    handedness = determinant(vectors) < 0 ? -1 : 1;
    const glm::dvec3 a = vectors[0], b = vectors[1], c = vectors[2];
    normals = handedness * glm::dmat3(cross(b, c), cross(c, a), cross(a, b));
  }
};

int attribute(const tinygltf::Primitive& primitive, const char* name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

bool has_attribute(const tinygltf::Primitive& primitive, const char* name) {
  return primitive.attributes.contains(name);
}

// Reads attributes of one primitive at the vertices that its triangles use.
class VertexReader {
 public:
  VertexReader(const Document& document, const tinygltf::Primitive& primitive, std::string item)
      : document_(document),
        primitive_(primitive),
        item_(std::move(item)),
        vertex_count_(elements("POSITION", TINYGLTF_TYPE_VEC3).count) {}

  std::size_t vertex_count() const { return vertex_count_; }

  template <class Vector, class Convert>
  std::vector<Vector> read(const char* name, int type, const std::vector<std::uint32_t>& vertices,
                           Convert convert) const {
    const Elements source = elements(name, type);
    if (source.count != vertex_count_)
      fail(name, std::to_string(source.count) + " elements, but there are " + std::to_string(vertex_count_) +
                     " positions");
    std::vector<Vector> values(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      values[i] = convert(source, vertices[i]);
      for (int c = 0; c < int(Vector::length()); ++c)
        if (!std::isfinite(values[i][c]))
          fail(name, "element " + std::to_string(vertices[i]) + " is not finite");
    }
    return values;
  }

 private:
  Elements elements(const char* name, int type) const {
    return attribute_elements(document_, attribute(primitive_, name), type, item_ + ", " + name);
  }

  [[noreturn]] void fail(const char* name, const std::string& problem) const {
    document_.fail(
        item_ + ", " + name + ", " + item_name("accessor", std::size_t(attribute(primitive_, name))),
        problem);
  }

  const Document& document_;
  const tinygltf::Primitive& primitive_;
  std::string item_;
  std::size_t vertex_count_;
};

// Renumbers the triangles' vertices from 0 in ascending order; returns their numbers in the file.
std::vector<std::uint32_t> compact(std::vector<uvec3>& triangles) {
  if (triangles.empty()) return {};
  std::uint32_t lowest = ~0u, highest = 0;
  for (const uvec3& t : triangles) {
    lowest = std::min({lowest, t.x, t.y, t.z});
    highest = std::max({highest, t.x, t.y, t.z});
  }
  std::vector<std::uint32_t> place(std::size_t(highest) - lowest + 1, 0), used;
  for (const uvec3& t : triangles)
    for (int corner = 0; corner < 3; ++corner) place[t[corner] - lowest] = 1;
  for (std::size_t v = 0; v < place.size(); ++v)
    if (place[v]) {
      place[v] = std::uint32_t(used.size());
      used.push_back(lowest + std::uint32_t(v));
    }
  for (uvec3& t : triangles) t = {place[t.x - lowest], place[t.y - lowest], place[t.z - lowest]};
  return used;
}

Mesh read_part(const VertexReader& reader, const tinygltf::Primitive& primitive,
               std::vector<uvec3> triangles) {
  const auto as_vec2 = [](const Elements& e, std::size_t i) { return e.as_vec2(i); };
  const auto as_vec3 = [](const Elements& e, std::size_t i) { return e.as_vec3(i); };
  const auto as_vec4 = [](const Elements& e, std::size_t i) { return e.as_vec4(i); };
  const std::vector<std::uint32_t> used = compact(triangles);
  Mesh part;
  part.triangles = std::move(triangles);
  part.positions = reader.read<vec3>("POSITION", TINYGLTF_TYPE_VEC3, used, as_vec3);
  part.uvs.resize(used.size(), vec2(0));
  part.tangents.resize(used.size(), vec4(0, 0, 0, 1));
  if (has_attribute(primitive, "TEXCOORD_0"))
    part.uvs = reader.read<vec2>("TEXCOORD_0", TINYGLTF_TYPE_VEC2, used, as_vec2);
  if (!has_attribute(primitive, "NORMAL")) return part;  // glTF: then given tangents do not count either
  part.normals = reader.read<vec3>("NORMAL", TINYGLTF_TYPE_VEC3, used, as_vec3);
  if (has_attribute(primitive, "TANGENT"))
    part.tangents = reader.read<vec4>("TANGENT", TINYGLTF_TYPE_VEC4, used, as_vec4);
  return part;
}

void carry(Mesh& part, const SurfaceMap& map) {
  for (vec3& p : part.positions) p = vec3(map.points * glm::dvec4(p, 1));
  for (vec3& n : part.normals) {
    const glm::dvec3 carried = map.normals * glm::dvec3(n);
    const double size = length(carried);
    n = size > 0 ? vec3(carried / size) : vec3(0);
  }
  for (vec4& t : part.tangents)
    t = vec4(vec3(map.vectors * glm::dvec3(t)), t.w < 0 ? -map.handedness : map.handedness);
  if (map.handedness < 0)
    for (uvec3& triangle : part.triangles) std::swap(triangle.y, triangle.z);
}

bool in_range(const Mesh& part) {
  return std::all_of(part.positions.begin(), part.positions.end(), [](const vec3& p) {
    const vec3 size = glm::abs(p);
    return size.x <= largest_coordinate && size.y <= largest_coordinate && size.z <= largest_coordinate;
  });
}

// Gives every vertex a unit normal and, where a normal texture needs them, tangents.
void complete(Mesh& part, bool has_tangents, bool needs_tangents, Warnings& warnings) {
  warnings.count("zero-area triangles dropped", drop_flat_triangles(part));
  if (part.normals.empty()) {
    make_flat_normals(part);
  } else {
    drop_unused_vertices(part);
    warnings.count("zero normals replaced by geometric ones", normalize_normals(part));
  }
  if (has_tangents)
    orthonormalize_tangents(part);
  else if (needs_tangents)
    make_tangents(part);
}

}  // namespace

void MeshBuilder::append(const MeshPlacement& placement) {
  const tinygltf::Node& node = document_.model.nodes[placement.node];
  if (node.mesh == -1) return;
  const std::string name = node_name(document_, placement.node);
  if (!has_item(document_.model.meshes, node.mesh))
    document_.fail(name, "there is no mesh " + std::to_string(node.mesh));
  if (node.skin != -1) warnings_.count("skins ignored, their meshes stay where their nodes are");
  const tinygltf::Mesh& mesh = document_.model.meshes[std::size_t(node.mesh)];
  const std::string item = item_name("mesh", std::size_t(node.mesh), mesh.name);
  for (std::size_t i = 0; i < mesh.primitives.size(); ++i)
    append_primitive(placement, mesh.primitives[i], item + ", " + item_name("primitive", i));
}

void MeshBuilder::append_primitive(const MeshPlacement& placement, const tinygltf::Primitive& primitive,
                                   const std::string& item) {
  const int mode = primitive.mode;
  if (mode < TINYGLTF_MODE_POINTS || mode > TINYGLTF_MODE_TRIANGLE_FAN)
    document_.fail(item, "mode " + std::to_string(mode) + " is unknown");
  if (mode < TINYGLTF_MODE_TRIANGLES) return warnings_.count("point and line primitives dropped");
  if (!has_attribute(primitive, "POSITION")) return warnings_.count("primitives without positions dropped");
  const VertexReader reader(document_, primitive, item);
  const auto indices = read_indices(document_, primitive, reader.vertex_count(), item);
  if (mode == TINYGLTF_MODE_TRIANGLES && indices.size() % 3 != 0)
    warnings_.count("incomplete triangles at the end of a list dropped");
  std::vector<uvec3> triangles = assemble_triangles(indices, mode);
  admit_triangles(triangles.size(), item);
  warn_of_ignored(primitive);

  const std::uint32_t material = material_index(primitive, item);
  Mesh part = read_part(reader, primitive, std::move(triangles));
  part.materials.assign(part.triangles.size(), material);
  carry(part, SurfaceMap(placement.to_frame));
  if (!in_range(part))
    document_.fail(node_name(document_, placement.node) + ", " + item,
                   "a coordinate exceeds 1e9 in the world", "scale or move the scene");
  const bool has_tangents = !part.normals.empty() && has_attribute(primitive, "TANGENT");
  const bool needs_tangents = scene_.materials[material].normal_texture >= 0;
  complete(part, has_tangents, needs_tangents, warnings_);
  admit_vertices(part.positions.size(), item);
  coppice::append(placement.into, part);
}

std::uint32_t MeshBuilder::material_index(const tinygltf::Primitive& primitive, const std::string& item) {
  if (has_item(document_.model.materials, primitive.material)) return std::uint32_t(primitive.material);
  if (primitive.material != -1)
    document_.fail(item, "there is no material " + std::to_string(primitive.material));
  if (default_material_ == ~0u) {
    default_material_ = std::uint32_t(scene_.materials.size());
    scene_.materials.push_back({});
    scene_.materials.back().name = "default";
  }
  return default_material_;
}

void MeshBuilder::warn_of_ignored(const tinygltf::Primitive& primitive) {
  if (has_attribute(primitive, "COLOR_0")) warnings_.count("primitives' vertex colours ignored");
  if (!primitive.targets.empty()) warnings_.count("primitives' morph targets ignored");
}

// Counts triangles before they may be dropped, as every one costs time.
void MeshBuilder::admit_triangles(std::size_t count, const std::string& item) {
  triangle_count_ += count;
  if (triangle_count_ > most_triangles)
    document_.fail(item, "the scene exceeds 2^26 triangles", "split the scene");
}

void MeshBuilder::admit_vertices(std::size_t count, const std::string& item) {
  vertex_count_ += count;
  if (vertex_count_ > most_vertices)
    document_.fail(item, "the scene exceeds 2^26 vertices", "split the scene");
}

}  // namespace coppice::gltf
