// Heap ids of the complete tree against an explicit recursion.
#include <coppice/shared/node.h>
#include <doctest/doctest.h>

#include <vector>

using namespace coppice;

namespace {

void visit(uint leaf_count, uint node, uint begin, uint end, std::vector<uint>& order) {
  order.push_back(node);
  CHECK(node_of_range(leaf_count, begin, end) == node);
  if (end - begin == 1) return;
  const uint middle = (begin + end) / 2;
  visit(leaf_count, 2 * node, begin, middle, order);
  visit(leaf_count, 2 * node + 1, middle, end, order);
}

}  // namespace

TEST_CASE("a range of leaves names its node, and the stackless walk is the depth-first order") {
  for (const uint leaf_count : {1u, 2u, 4u, 64u, 1024u}) {
    std::vector<uint> recursive, stackless;
    visit(leaf_count, 1, 0, leaf_count, recursive);
    uint node = 1;
    do {
      stackless.push_back(node);
      node = node < leaf_count ? 2 * node : node_after(node);
    } while (node != 1);
    CHECK(stackless == recursive);
  }
}
