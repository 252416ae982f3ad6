// Nodes as ranges of leaves.
#include <doctest/doctest.h>

#include <coppice/tree/light_tree.hpp>

using namespace coppice;

TEST_CASE("a node's children halve its leaves, and the range leads back to the node") {
  for (const std::uint32_t n : {1u, 2u, 8u, 1024u, 32768u}) {
    CHECK(leaves_below(n, 1) == LeafRange{0, n});
    bool halved = true, returned = true;
    for (std::uint32_t h = 1; h < 2 * n; ++h) {
      const LeafRange r = leaves_below(n, h);
      returned = returned && node_of_range(n, r.begin, r.end) == h;
      if (h >= n) {
        halved = halved && r == LeafRange{h - n, h - n + 1};
        continue;
      }
      const std::uint32_t middle = (r.begin + r.end) / 2;
      halved = halved && leaves_below(n, 2 * h) == LeafRange{r.begin, middle};
      halved = halved && leaves_below(n, 2 * h + 1) == LeafRange{middle, r.end};
    }
    CHECK(halved);
    CHECK(returned);
  }
}

TEST_CASE("the tree holds as many leaves as the next power of two") {
  CHECK(leaf_count_for(0) == 0);
  CHECK(leaf_count_for(1) == 1);
  CHECK(leaf_count_for(2) == 2);
  CHECK(leaf_count_for(3) == 4);
  CHECK(leaf_count_for(32768) == 32768);
  CHECK(leaf_count_for(32769) == 65536);
}

TEST_CASE("a tree without lights is empty") {
  CHECK(LightTree().empty());
  CHECK(LightTree().leaf_count() == 0);
}

TEST_CASE("leaves hold every light once, and no more padding than is needed") {
  const std::vector<std::uint32_t> leaves{2, no_light, 0, 1};
  CHECK(are_leaves(leaves, 3));
  CHECK(are_leaves({}, 0));
  CHECK(are_leaves(std::vector<std::uint32_t>{0}, 1));
  CHECK_FALSE(are_leaves(leaves, 2));
  CHECK_FALSE(are_leaves(leaves, 4));
  CHECK_FALSE(are_leaves({}, 1));
  CHECK_FALSE(are_leaves(std::vector<std::uint32_t>{0, 0, 1, no_light}, 3));
  CHECK_FALSE(are_leaves(std::vector<std::uint32_t>{0, 1, no_light, no_light}, 2));
  CHECK_FALSE(are_leaves(leaves, std::size_t(1) << 40));
}

TEST_CASE("a tree over given leaves counts the lights below each node") {
  const LightTree tree = tree_over({2, no_light, 0, 1});
  CHECK(tree.light_of_leaf == std::vector<std::uint32_t>{2, no_light, 0, 1});
  CHECK(tree.light_count == std::vector<std::uint32_t>{0, 3, 1, 2, 1, 0, 1, 1});
  CHECK(tree_over({}).light_count.empty());
  CHECK(tree_over({0}).light_count == std::vector<std::uint32_t>{0, 1});
}
