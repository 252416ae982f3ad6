#include "mesh_arrays.hpp"

#include <algorithm>
#include <array>

#include "refusal.hpp"

namespace coppice::store {
namespace {

using Corner = ReceiverMesh::Corner;
using Face = ReceiverMesh::Face;

constexpr std::uint32_t middle_code = 3, vertex_codes = 6, child_codes = 216;
constexpr std::uint32_t most_children = 4;

bool is_corner(std::uint32_t corner) { return corner != no_face; }

struct Edge {
  std::uint32_t a, b;  ///< corners, a <= b
};

Edge edge_of(const Face& face, int k) {
  const std::uint32_t a = face.corners[k], b = face.corners[(k + 1) % 3];
  return {std::min(a, b), std::max(a, b)};
}

vec2 middle_uv(const Face& face, std::size_t k) { return 0.5f * (face.uv[k] + face.uv[(k + 1) % 3]); }

/// As refine_receivers places corners.
Corner middle_of(const Corner& a, const Corner& b) {
  return {0.5f * (a.position + b.position), normalize_or(a.normal + b.normal, a.normal)};
}

/// Compilers may round normals differently from one file to the next.
bool agree(const Corner& a, const Corner& b) {
  return a.position == b.position && length(a.normal - b.normal) <= 1e-6f;
}

class MeshEncoder {
 public:
  explicit MeshEncoder(const ReceiverMesh& mesh) : mesh_(mesh), is_middle_(mesh.corners().size(), false) {}

  MeshArrays encode() {
    add_roots();
    std::uint32_t next = std::uint32_t(mesh_.sides().size());
    const std::vector<std::uint32_t> parents = parents_by_first_child();
    while (next < mesh_.faces().size()) {
      add_split(parents[next]);
      next += mesh_.faces()[parents[next]].child_count;
    }
    add_corners();
    return std::move(arrays_);
  }

 private:
  void add_roots() {
    for (std::size_t f = 0; f < mesh_.sides().size(); ++f) {
      const Face& face = mesh_.faces()[f];
      arrays_.root_corners.push_back(face.corners);
      arrays_.root_normals.push_back(face.normal);
      arrays_.root_triangles.push_back(face.triangle);
      arrays_.root_fronts.push_back(mesh_.sides()[f].front);
      for (int k = 0; k < 3; ++k) settled_.push_back(face.corners[k]);
    }
    for (const std::uint32_t corner : settled_) must_be_stored_ = std::max(must_be_stored_, corner + 1);
  }

  std::vector<std::uint32_t> parents_by_first_child() const {
    std::vector<std::uint32_t> parents(mesh_.faces().size(), no_face);
    for (std::uint32_t f = 0; f < mesh_.faces().size(); ++f)
      if (!mesh_.is_leaf(f)) parents[mesh_.faces()[f].first_child] = f;
    return parents;
  }

  void add_split(std::uint32_t f) {
    const Face& parent = mesh_.faces()[f];
    std::array<std::uint32_t, 3> middles{no_face, no_face, no_face};
    if (parent.child_count > most_children) throw elsewhere(f);
    arrays_.split_faces.push_back(f);
    arrays_.split_children.push_back(std::uint8_t(parent.child_count));
    for (std::uint32_t c = 0; c < parent.child_count; ++c) {
      std::uint32_t code = 0, power = 1;
      for (int k = 0; k < 3; ++k, power *= vertex_codes)
        code += power * vertex_code(f, mesh_.faces()[parent.first_child + c], k, middles);
      arrays_.children.push_back(std::uint8_t(code));
    }
    if (parent.child_count > std::size_t(std::ranges::count_if(middles, is_corner)) + 1) throw elsewhere(f);
    for (int k = 0; k < 3; ++k)
      if (middles[std::size_t(k)] != no_face) add_middle(edge_of(parent, k), middles[std::size_t(k)]);
  }

  std::uint32_t vertex_code(std::uint32_t f, const Face& child, int vertex,
                            std::array<std::uint32_t, 3>& middles) {
    const Face& parent = mesh_.faces()[f];
    const std::uint32_t corner = child.corners[vertex];
    const vec2 uv = child.uv[std::size_t(vertex)];
    for (std::uint32_t k = 0; k < 3; ++k)
      if (corner == parent.corners[int(k)] && uv == parent.uv[k]) return k;
    for (std::uint32_t k = 0; k < 3; ++k)
      if (uv == middle_uv(parent, k) && (middles[k] == no_face || middles[k] == corner)) {
        middles[k] = corner;
        return middle_code + k;
      }
    throw elsewhere(f);
  }

  void add_middle(Edge edge, std::uint32_t corner) {
    arrays_.middles.push_back(corner);
    if (is_middle_[corner]) return;
    is_middle_[corner] =
        agree(mesh_.corners()[corner], middle_of(mesh_.corners()[edge.a], mesh_.corners()[edge.b]));
    if (!is_middle_[corner]) must_be_stored_ = std::max(must_be_stored_, corner + 1);
  }

  void add_corners() {
    arrays_.corner_count = std::uint32_t(mesh_.corners().size());
    for (std::uint32_t c = must_be_stored_; c < arrays_.corner_count; ++c)
      if (!is_middle_[c]) must_be_stored_ = c + 1;
    for (std::uint32_t c = 0; c < must_be_stored_; ++c) {
      arrays_.corner_positions.push_back(mesh_.corners()[c].position);
      arrays_.corner_normals.push_back(mesh_.corners()[c].normal);
    }
  }

  static Refusal elsewhere(std::uint32_t face) {
    return Refusal(
        "cannot hold face " + std::to_string(face) + ", which is split elsewhere than at its middles",
        "refine with refine_receivers");
  }

  const ReceiverMesh& mesh_;
  MeshArrays arrays_;
  std::vector<bool> is_middle_;
  std::vector<std::uint32_t> settled_;
  std::uint32_t must_be_stored_ = 0;
};

class MeshDecoder {
 public:
  explicit MeshDecoder(const MeshArrays& arrays) : arrays_(arrays) {}

  ReceiverMesh decode() {
    add_corners();
    add_roots();
    for (std::size_t s = 0; s < arrays_.split_faces.size(); ++s) add_split(s);
    require(next_child_ == arrays_.children.size() && next_middle_ == arrays_.middles.size(),
            "does not use all its children and middles");
    for (const bool is_known : is_known_) require(is_known, "has a corner that is nowhere");
    return ReceiverMesh::from_arrays(std::move(corners_), std::move(faces_), sides_);
  }

 private:
  static void require(bool condition, const char* problem) {
    if (!condition) throw Refusal(std::string("the mesh ") + problem);
  }

  void add_corners() {
    const std::size_t stored = arrays_.corner_positions.size();
    require(arrays_.corner_count >= stored && arrays_.corner_count - stored <= arrays_.middles.size(),
            "has more corners than middles of edges");
    require(arrays_.children.size() / 2 <= arrays_.middles.size(),
            "has more children than its middles can make");
    corners_.resize(arrays_.corner_count);
    is_known_.resize(corners_.size(), false);
    for (std::size_t c = 0; c < stored; ++c)
      corners_[c] = {arrays_.corner_positions[c], arrays_.corner_normals[c]}, is_known_[c] = true;
  }

  void add_roots() {
    faces_.reserve(arrays_.root_corners.size() + arrays_.children.size());
    for (std::size_t f = 0; f < arrays_.root_corners.size(); ++f) {
      const uvec3 c = arrays_.root_corners[f];
      for (int k = 0; k < 3; ++k)
        require(c[k] < corners_.size() && is_known_[c[k]], "has a face without corners");
      require(arrays_.root_fronts[f] <= 1, "has a face that is neither front nor back");
      faces_.push_back(
          {c, {vec2(0, 0), vec2(1, 0), vec2(0, 1)}, arrays_.root_normals[f], arrays_.root_triangles[f]});
      sides_.push_back({arrays_.root_triangles[f], arrays_.root_fronts[f] == 1});
    }
  }

  void add_split(std::size_t s) {
    const std::uint32_t f = arrays_.split_faces[s], count = arrays_.split_children[s];
    require(f < faces_.size() && faces_[f].child_count == 0, "splits a face twice, or one that is not there");
    require(count > 0 && count <= arrays_.children.size() - next_child_, "lacks children");
    const std::span<const std::uint8_t> codes = std::span(arrays_.children).subspan(next_child_, count);
    const Face parent = faces_[f];
    const std::array<std::uint32_t, 3> middles = take_middles(parent, codes);
    faces_[f].first_child = std::uint32_t(faces_.size());
    faces_[f].child_count = count;
    for (const std::uint8_t code : codes) faces_.push_back(child_of(parent, middles, code));
    next_child_ += count;
  }

  std::array<std::uint32_t, 3> take_middles(const Face& parent, std::span<const std::uint8_t> codes) {
    std::array<bool, vertex_codes> is_used{};
    for (std::uint32_t code : codes) {
      require(code < child_codes, "has a child of unknown shape");
      for (int k = 0; k < 3; ++k, code /= vertex_codes) is_used[code % vertex_codes] = true;
    }
    require(codes.size() <=
                std::size_t(std::ranges::count(is_used.begin() + middle_code, is_used.end(), true)) + 1,
            "has more children than its middles can make");
    std::array<std::uint32_t, 3> middles{};
    for (int k = 0; k < 3; ++k)
      if (is_used[middle_code + std::size_t(k)]) middles[std::size_t(k)] = take_middle(edge_of(parent, k));
    return middles;
  }

  std::uint32_t take_middle(Edge edge) {
    require(next_middle_ < arrays_.middles.size(), "lacks middles");
    const std::uint32_t corner = arrays_.middles[next_middle_++];
    require(corner < corners_.size(), "has a middle that is no corner");
    if (!is_known_[corner]) corners_[corner] = middle_of(corners_[edge.a], corners_[edge.b]);
    is_known_[corner] = true;
    return corner;
  }

  static Face child_of(const Face& parent, const std::array<std::uint32_t, 3>& middles, std::uint32_t code) {
    Face child{{}, {}, parent.normal, parent.triangle};
    for (std::size_t k = 0; k < 3; ++k, code /= vertex_codes) {
      const std::uint32_t v = code % vertex_codes, edge = v - middle_code;
      child.corners[int(k)] = v < middle_code ? parent.corners[int(v)] : middles[edge];
      child.uv[k] = v < middle_code ? parent.uv[v] : middle_uv(parent, edge);
    }
    return child;
  }

  const MeshArrays& arrays_;
  std::vector<Corner> corners_;
  std::vector<bool> is_known_;
  std::vector<Face> faces_;
  std::vector<SidedTriangle> sides_;
  std::size_t next_child_ = 0, next_middle_ = 0;
};

}  // namespace

MeshArrays arrays_of(const ReceiverMesh& mesh) { return MeshEncoder(mesh).encode(); }

ReceiverMesh mesh_of(const MeshArrays& arrays) { return MeshDecoder(arrays).decode(); }

}  // namespace coppice::store
