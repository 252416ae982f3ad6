// What a cut is, and is not.
#include <doctest/doctest.h>

#include <coppice/cut/cut.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

using Ends = std::vector<std::uint32_t>;

TEST_CASE("a random cut covers every leaf once by nodes") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(10);
    Random random = any_random();
    const auto cut = any_cut<float>(random, n);
    RC_ASSERT(is_cut(n, cut.ends));
    RC_ASSERT(cut.values.size() == cut.size());
    std::vector<int> covered(n, 0);
    for_each_piece(cut.ends, [&](LeafRange r, std::size_t) {
      for (std::uint32_t leaf = r.begin; leaf < r.end; ++leaf) ++covered[leaf];
      RC_ASSERT(leaves_below(n, node_of_range(n, r.begin, r.end)) == r);
    });
    RC_ASSERT(covered == std::vector<int>(n, 1));
  }));
}

TEST_CASE("is_cut accepts exactly the cuts of a small tree") {
  int cuts = 0;
  for (std::uint32_t mask = 0; mask < 256; ++mask) {
    Ends ends;
    for (std::uint32_t bit = 0; bit < 8; ++bit)
      if (mask >> bit & 1) ends.push_back(bit + 1);
    cuts += is_cut(8, ends);
  }
  CHECK(cuts == 26);  // cuts(2n) = 1 + cuts(n)²: 1, 2, 5, 26
}

TEST_CASE("is_cut rejects gaps, overlaps, pieces that are no nodes, and leaves beyond the tree") {
  for (const Ends& ends :
       {Ends{}, Ends{2}, Ends{4, 4}, Ends{2, 1, 4}, Ends{3, 4}, Ends{1, 3, 4}, Ends{8}, Ends{0, 4}})
    CHECK_FALSE(is_cut(4, ends));
  for (const Ends& ends : {Ends{4}, Ends{2, 4}, Ends{1, 2, 4}, Ends{1, 2, 3, 4}}) CHECK(is_cut(4, ends));
  CHECK(is_cut(0, Ends{}));
  CHECK_FALSE(is_cut(0, Ends{1}));
}

TEST_CASE("pieces come from left to right with their index") {
  std::vector<LeafRange> pieces;
  for_each_piece(Ends{1, 2, 4}, [&](LeafRange r, std::size_t i) {
    CHECK(i == pieces.size());
    pieces.push_back(r);
  });
  CHECK(pieces == std::vector<LeafRange>{{0, 1}, {1, 2}, {2, 4}});
}

TEST_CASE("values are those of the pieces' nodes, and a view sees the cut") {
  const auto cut = cut_with_values(8, Ends{4, 6, 7, 8}, [](std::uint32_t h) { return h; });
  CHECK(cut.values == std::vector<std::uint32_t>{2, 6, 14, 15});
  const CutView<std::uint32_t> view = cut;
  CHECK(view.size() == 4);
  CHECK(view.ends.data() == cut.ends.data());
  CHECK(view.values.data() == cut.values.data());
}
