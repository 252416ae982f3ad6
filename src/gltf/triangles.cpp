#include "triangles.hpp"

#include <numeric>

#include "accessor.hpp"

namespace coppice::gltf {
namespace {

uvec3 corners(std::size_t triangle, int mode) {
  const auto i = std::uint32_t(triangle);
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) return {i, i + 1 + i % 2, i + 2 - i % 2};
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {i + 1, i + 2, 0};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

}  // namespace

std::vector<std::uint32_t> read_indices(const Document& document, const tinygltf::Primitive& primitive,
                                        std::size_t vertex_count, const std::string& item) {
  if (primitive.indices == -1) {
    std::vector<std::uint32_t> indices(vertex_count);
    std::iota(indices.begin(), indices.end(), 0u);
    return indices;
  }
  const std::string owner = item + ", indices";
  const Elements elements = index_elements(document, primitive.indices, owner);
  std::vector<std::uint32_t> indices(elements.count);
  for (std::size_t i = 0; i < elements.count; ++i) {
    indices[i] = elements.index(i);
    if (indices[i] >= vertex_count)
      document.fail(owner + ", " + item_name("accessor", std::size_t(primitive.indices)),
                    "index " + std::to_string(indices[i]) + " is out of range, there are " +
                        std::to_string(vertex_count) + " vertices");
  }
  return indices;
}

std::vector<uvec3> assemble_triangles(const std::vector<std::uint32_t>& indices, int mode) {
  const bool list = mode == TINYGLTF_MODE_TRIANGLES;
  const std::size_t count = list ? indices.size() / 3 : indices.size() < 3 ? 0 : indices.size() - 2;
  std::vector<uvec3> triangles(count);
  for (std::size_t t = 0; t < count; ++t) {
    const uvec3 c = corners(t, mode);
    triangles[t] = {indices[c.x], indices[c.y], indices[c.z]};
  }
  return triangles;
}

}  // namespace coppice::gltf
