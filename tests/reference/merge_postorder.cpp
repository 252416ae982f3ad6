// The paper's merge: its numbering, its worked example, and its sums against those of the leaves.
#include <doctest/doctest.h>

#include <coppice/cut/merge.hpp>
#include <coppice/reference/merge_per_leaf.hpp>
#include <coppice/reference/merge_postorder.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace coppice::reference;
using namespace test_support;

namespace {

std::vector<std::uint32_t> indices(const std::vector<PostorderNode>& nodes) {
  std::vector<std::uint32_t> result;
  for (const auto& n : nodes) result.push_back(n.index);
  return result;
}

/// Numbers the subtree in postorder and checks every node's index and leftmost leaf.
std::uint32_t number(std::uint32_t leaf_count, std::uint32_t h, std::uint32_t next) {
  const std::uint32_t first = next;
  if (h < leaf_count) next = number(leaf_count, 2 * h + 1, number(leaf_count, 2 * h, next));
  const PostorderNode node = postorder_node(leaves_below(leaf_count, h), 0);
  CHECK(node.index == next);
  CHECK(node.leftleaf == first);
  return next + 1;
}

}  // namespace

TEST_CASE("indices are those of a postorder traversal") {
  for (const std::uint32_t n : {1u, 2u, 8u, 128u}) CHECK(number(n, 1, 0) == 2 * n - 1);
}

TEST_CASE("the example of Figures 3 and 4: five steps, the third finds no overlap") {
  const Cut<float> orange{{2, 3, 4}, {1, 2, 3}}, purple{{1, 2, 4}, {5, 7, 11}};
  const std::vector cuts{to_postorder(CutView<float>(orange)), to_postorder(CutView<float>(purple))};
  CHECK(indices(cuts[0]) == std::vector<std::uint32_t>{2, 3, 4});
  CHECK(indices(cuts[1]) == std::vector<std::uint32_t>{0, 1, 5});
  std::vector<std::vector<double>> visited;
  merge_postorder(cuts, [&](std::uint32_t leaves, std::span<const PostorderNode> nodes) {
    visited.push_back({double(leaves), nodes[0].value, nodes[1].value});
  });
  CHECK(visited == std::vector<std::vector<double>>{{1, 1, 5}, {1, 1, 7}, {1, 2, 11}, {1, 3, 11}});
  CHECK(product_integral_postorder(cuts) == 5 + 7 + 22 + 33);
}

TEST_CASE("the paper's merge gives the sums of the leaves and of the merge by ends") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(9);
    Random random = any_random();
    std::vector<Cut<float>> cuts(*rc::gen::inRange<std::size_t>(1, 10));
    std::vector<std::vector<PostorderNode>> postorder;
    std::vector<std::vector<double>> leaves;
    for (auto& cut : cuts) {
      cut = any_cut<float>(random, n);
      postorder.push_back(to_postorder(CutView<float>(cut)));
      leaves.push_back(expand(CutView<float>(cut)));
    }
    const double tolerance = 1e-12 * n;
    RC_ASSERT(std::abs(product_integral_postorder(postorder) - product_integral_per_leaf(leaves)) <=
              tolerance);
    const double pair = product_integral(cuts.front(), cuts.back());
    RC_ASSERT(std::abs(product_integral_postorder({postorder.front(), postorder.back()}) - pair) <=
              tolerance);
  }));
}

TEST_CASE("its visits are the pieces of the merge by ends, in the same order") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(9);
    Random random = any_random();
    const auto a = any_cut<float>(random, n), b = any_cut<float>(random, n), c = any_cut<float>(random, n);
    std::vector<std::vector<double>> by_ends, by_postorder;
    merge_cuts(
        [&](LeafRange r, auto... values) {
          by_ends.push_back({double(r.size()), double(values)...});
        },
        a, b, c);
    merge_postorder(
        {to_postorder(CutView<float>(a)), to_postorder(CutView<float>(b)), to_postorder(CutView<float>(c))},
        [&](std::uint32_t leaves, std::span<const PostorderNode> nodes) {
          by_postorder.push_back({double(leaves), nodes[0].value, nodes[1].value, nodes[2].value});
        });
    RC_ASSERT(by_ends == by_postorder);
  }));
}

TEST_CASE("cuts without pieces have no product") { CHECK(product_integral_postorder({{}, {}}) == 0); }
