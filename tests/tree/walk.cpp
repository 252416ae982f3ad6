// The stackless walk against a recursion that prunes at the same nodes.
#include <doctest/doctest.h>

#include <coppice/tree/walk.hpp>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

void recurse(std::uint32_t leaf_count, std::uint32_t h, const std::vector<bool>& into,
             std::vector<std::uint32_t>& order) {
  order.push_back(h);
  if (h >= leaf_count || !into[h]) return;
  recurse(leaf_count, 2 * h, into, order);
  recurse(leaf_count, 2 * h + 1, into, order);
}

std::vector<std::uint32_t> walked(std::uint32_t leaf_count, const std::vector<bool>& into) {
  std::vector<std::uint32_t> order;
  walk_tree(leaf_count, [&](std::uint32_t h) {
    order.push_back(h);
    return bool(into[h]);
  });
  return order;
}

}  // namespace

TEST_CASE("the walk visits the whole tree in preorder") {
  for (const std::uint32_t n : {1u, 2u, 4u, 1024u}) {
    const std::vector<bool> all(2 * n, true);
    std::vector<std::uint32_t> expected;
    recurse(n, 1, all, expected);
    CHECK(expected.size() == 2 * n - 1);
    CHECK(walked(n, all) == expected);
    CHECK(walked(n, std::vector<bool>(2 * n, false)) == std::vector<std::uint32_t>{1});
  }
}

TEST_CASE("the walk leaves out exactly the subtrees that are not descended") {
  CHECK(rc::check([] {
    const std::uint32_t n = any_leaf_count(9);
    Random random = any_random();
    const float chance = float(*rc::gen::inRange(0, 101)) * 0.01f;
    std::vector<bool> into(2 * n);
    for (std::size_t h = 0; h < into.size(); ++h) into[h] = random.uniform() < chance;
    std::vector<std::uint32_t> expected;
    recurse(n, 1, into, expected);
    RC_ASSERT(walked(n, into) == expected);
  }));
}

TEST_CASE("a tree without leaves is not walked") { CHECK(walked(0, {true, true}).empty()); }
