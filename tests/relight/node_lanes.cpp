// A register of nodes against the nodes themselves.
#include <doctest/doctest.h>

#include <coppice/relight/node_lanes.hpp>

using namespace coppice;

namespace {

/// Nodes whose every field is another number.
std::vector<LightNode> numbered_nodes(std::size_t count) {
  std::vector<LightNode> nodes;
  for (std::size_t i = 0; i < count; ++i) {
    const float k = 8 * float(i);
    nodes.push_back({{k, k + 1, k + 2}, k + 3, {k + 4, k + 5, k + 6}, k + 7});
  }
  return nodes;
}

float lane(Lanes x, std::size_t i) {
  float all[Lanes::width];
  x.store(all);
  return all[i];
}

}  // namespace

TEST_CASE("a register of nodes has every field of every node in its lane, from any node on") {
  const auto nodes = numbered_nodes(Lanes::width + 5);
  for (std::size_t first = 0; first <= 5; ++first) {
    const NodeLanes lanes = load_nodes(nodes.data() + first);
    for (std::size_t i = 0; i < Lanes::width; ++i) {
      const LightNode& node = nodes[first + i];
      CHECK(vec3(lane(lanes.red, i), lane(lanes.green, i), lane(lanes.blue, i)) == node.power);
      CHECK(lane(lanes.spread, i) == node.spread);
      CHECK(vec3(lane(lanes.x, i), lane(lanes.y, i), lane(lanes.z, i)) == node.direction);
    }
  }
}

TEST_CASE("room for nodes reaches a register beyond them, and what is there already stays") {
  std::vector<LightNode> nodes;
  make_room(nodes, 3);
  CHECK(nodes.size() >= 3 + Lanes::width);
  nodes[2].spread = 0.5f;
  make_room(nodes, 1000);
  CHECK(nodes.size() >= 1000 + Lanes::width);
  CHECK(nodes[2].spread == 0.5f);
}
