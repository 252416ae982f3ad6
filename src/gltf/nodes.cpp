#include "nodes.hpp"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <utility>

namespace coppice::gltf {
namespace {

bool is_finite(const glm::dmat4& m) {
  const double* first = glm::value_ptr(m);
  return std::all_of(first, first + 16, [](double value) { return std::isfinite(float(value)); });
}

glm::dmat4 given_matrix(const Document& document, std::size_t node) {
  const std::vector<double>& values = document.model.nodes[node].matrix;
  if (values.size() != 16) document.fail(node_name(document, node), "its matrix has not 16 numbers");
  if (values[3] != 0 || values[7] != 0 || values[11] != 0 || values[15] != 1)
    document.fail(node_name(document, node), "the last row of its matrix is not 0 0 0 1");
  return glm::make_mat4(values.data());
}

glm::dmat4 composed_matrix(const Document& document, std::size_t node) {
  const tinygltf::Node& source = document.model.nodes[node];
  const auto check = [&](const std::vector<double>& values, std::size_t size, const char* what) {
    if (!values.empty() && values.size() != size)
      document.fail(node_name(document, node),
                    std::string("its ") + what + " has not " + std::to_string(size) + " numbers");
    return !values.empty();
  };
  glm::dmat4 matrix{1};
  if (check(source.translation, 3, "translation"))
    matrix = glm::translate(matrix, glm::make_vec3(source.translation.data()));
  if (check(source.rotation, 4, "rotation")) {
    const std::vector<double>& r = source.rotation;
    const double size = std::hypot(std::hypot(r[0], r[1]), std::hypot(r[2], r[3]));
    if (!(size > 0) || !std::isfinite(size))
      document.fail(node_name(document, node), "its rotation is not a unit quaternion");
    matrix = matrix * glm::mat4_cast(glm::dquat(r[3] / size, r[0] / size, r[1] / size, r[2] / size));
  }
  if (check(source.scale, 3, "scale")) matrix = glm::scale(matrix, glm::make_vec3(source.scale.data()));
  return matrix;
}

std::vector<char> marked_children(const Document& document) {
  const auto& nodes = document.model.nodes;
  std::vector<char> is_child(nodes.size(), 0);
  for (std::size_t node = 0; node < nodes.size(); ++node)
    for (const int child : nodes[node].children) {
      if (!has_item(nodes, child))
        document.fail(node_name(document, node), "there is no child node " + std::to_string(child));
      if (std::exchange(is_child[std::size_t(child)], 1))
        document.fail(node_name(document, std::size_t(child)), "it has more than one parent",
                      "give every instance a node of its own");
    }
  return is_child;
}

// With one parent at most for each, the nodes that no parentless one reaches are those of cycles.
void check_no_cycles(const Document& document, std::vector<int> pending, std::vector<char> reached) {
  while (!pending.empty()) {
    const auto node = std::size_t(pending.back());
    pending.pop_back();
    reached[node] = 1;
    const std::vector<int>& children = document.model.nodes[node].children;
    pending.insert(pending.end(), children.begin(), children.end());
  }
  const auto lost = std::find(reached.begin(), reached.end(), 0);
  if (lost != reached.end())
    document.fail(node_name(document, std::size_t(lost - reached.begin())), "it is in a cycle of nodes");
}

std::vector<int> parentless_nodes(const Document& document) {
  const std::vector<char> is_child = marked_children(document);
  std::vector<int> roots;
  for (std::size_t node = 0; node < is_child.size(); ++node)
    if (!is_child[node]) roots.push_back(int(node));
  check_no_cycles(document, roots, std::vector<char>(is_child.size(), 0));
  return roots;
}

std::vector<int> scene_roots(const Document& document) {
  const tinygltf::Model& model = document.model;
  std::vector<int> parentless = parentless_nodes(document);
  if (model.scenes.empty()) return parentless;
  const int scene = model.defaultScene == -1 ? 0 : model.defaultScene;
  if (!has_item(model.scenes, scene)) document.fail("scene", "there is no scene " + std::to_string(scene));
  return model.scenes[std::size_t(scene)].nodes;
}

// Depth first without recursion: a chain of nodes may be as long as the file. Every node is placed once at
// most.
class Walk {
 public:
  explicit Walk(const Document& document) : document_(document), seen_(document.model.nodes.size(), 0) {}

  std::vector<PlacedNode> from(const std::vector<int>& roots) {
    push(roots, glm::dmat4{1});
    while (!pending_.empty()) {
      const PlacedNode parent = pending_.back();
      pending_.pop_back();
      placed_.push_back(place(parent));
      push(document_.model.nodes[parent.node].children, placed_.back().to_world);
    }
    return std::move(placed_);
  }

 private:
  void push(const std::vector<int>& nodes, const glm::dmat4& to_world) {
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
      if (!has_item(document_.model.nodes, *node))
        document_.fail("scene", "there is no node " + std::to_string(*node));
      if (std::exchange(seen_[std::size_t(*node)], 1))
        document_.fail(node_name(document_, std::size_t(*node)), "the scene holds it twice",
                       "give every instance a node of its own");
      pending_.push_back({std::size_t(*node), to_world});
    }
  }

  PlacedNode place(const PlacedNode& in_parent) const {
    const std::size_t node = in_parent.node;
    const bool given = !document_.model.nodes[node].matrix.empty();
    const glm::dmat4 local = given ? given_matrix(document_, node) : composed_matrix(document_, node);
    const glm::dmat4 to_world = in_parent.to_world * local;
    if (!is_finite(to_world)) document_.fail(node_name(document_, node), "its transform is not finite");
    return {node, to_world};
  }

  const Document& document_;
  std::vector<char> seen_;
  std::vector<PlacedNode> pending_, placed_;
};

}  // namespace

std::vector<PlacedNode> place_nodes(const Document& document) {
  return Walk(document).from(scene_roots(document));
}

std::string node_name(const Document& document, std::size_t node) {
  return item_name("node", node, document.model.nodes[node].name);
}

}  // namespace coppice::gltf
