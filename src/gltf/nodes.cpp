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
    push(roots, no_parent);
    while (!pending_.empty()) {
      const Pending next = pending_.back();
      pending_.pop_back();
      placed_.push_back(place(next));
      push(document_.model.nodes[next.node].children, placed_.size() - 1);
    }
    return std::move(placed_);
  }

 private:
  struct Pending {
    std::size_t node, parent;
  };

  void push(const std::vector<int>& nodes, std::size_t parent) {
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) {
      if (!has_item(document_.model.nodes, *node))
        document_.fail("scene", "there is no node " + std::to_string(*node));
      if (std::exchange(seen_[std::size_t(*node)], 1))
        document_.fail(node_name(document_, std::size_t(*node)), "the scene holds it twice",
                       "give every instance a node of its own");
      pending_.push_back({std::size_t(*node), parent});
    }
  }

  PlacedNode place(const Pending& next) const {
    const glm::dmat4 local = local_matrix(document_, next.node);
    const glm::dmat4 to_world = next.parent == no_parent ? local : placed_[next.parent].to_world * local;
    if (!is_finite(to_world)) document_.fail(node_name(document_, next.node), "its transform is not finite");
    return {next.node, next.parent, to_world};
  }

  const Document& document_;
  std::vector<char> seen_;
  std::vector<Pending> pending_;
  std::vector<PlacedNode> placed_;
};

}  // namespace

std::vector<PlacedNode> place_nodes(const Document& document) {
  return Walk(document).from(scene_roots(document));
}

glm::dmat4 LocalTransform::matrix() const {
  return glm::scale(glm::translate(glm::dmat4{1}, translation) * glm::mat4_cast(rotation), scale);
}

LocalTransform local_transform(const Document& document, std::size_t node) {
  const tinygltf::Node& source = document.model.nodes[node];
  const auto given = [&](const std::vector<double>& values, std::size_t size, const char* what) {
    if (!values.empty() && values.size() != size)
      document.fail(node_name(document, node),
                    std::string("its ") + what + " has not " + std::to_string(size) + " numbers");
    return !values.empty();
  };
  LocalTransform local;
  if (given(source.translation, 3, "translation"))
    local.translation = glm::make_vec3(source.translation.data());
  if (given(source.rotation, 4, "rotation")) {
    const std::vector<double>& r = source.rotation;
    const double size = std::hypot(std::hypot(r[0], r[1]), std::hypot(r[2], r[3]));
    if (!(size > 0) || !std::isfinite(size))
      document.fail(node_name(document, node), "its rotation is not a unit quaternion");
    local.rotation = glm::dquat(r[3] / size, r[0] / size, r[1] / size, r[2] / size);
  }
  if (given(source.scale, 3, "scale")) local.scale = glm::make_vec3(source.scale.data());
  return local;
}

glm::dmat4 local_matrix(const Document& document, std::size_t node) {
  const bool given = !document.model.nodes[node].matrix.empty();
  return given ? given_matrix(document, node) : local_transform(document, node).matrix();
}

std::string node_name(const Document& document, std::size_t node) {
  return item_name("node", node, document.model.nodes[node].name);
}

}  // namespace coppice::gltf
