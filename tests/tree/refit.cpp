// Sweeps over a few leaves' ancestors against sweeps over the whole tree.
#include <doctest/doctest.h>

#include <coppice/tree/aggregate.hpp>
#include <coppice/tree/refit.hpp>
#include <set>
#include <vector>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

/// Tells left from right, and every change below.
std::uint64_t combine(std::uint64_t left, std::uint64_t right) { return 31 * left + 17 * right + 1; }

std::vector<std::uint64_t> aggregate_all(const std::vector<std::uint64_t>& leaves) {
  return aggregate(
      std::uint32_t(leaves.size()), [&](std::uint32_t leaf) { return leaves[leaf]; }, combine);
}

/// Inner nodes above the leaves.
std::set<std::uint32_t> ancestors(std::uint32_t leaf_count, const std::vector<std::uint32_t>& leaves) {
  std::set<std::uint32_t> result;
  for (const std::uint32_t leaf : leaves)
    for (std::uint32_t h = (leaf_count + leaf) / 2; h > 0; h /= 2) result.insert(h);
  return result;
}

/// Changes the leaves, refits, and compares with a new aggregate.
void check_refit(Random& random, std::vector<std::uint64_t> leaves, const std::vector<std::uint32_t>& changed,
                 std::vector<std::uint32_t>& scratch) {
  const auto n = std::uint32_t(leaves.size());
  auto values = aggregate_all(leaves);
  for (const std::uint32_t leaf : changed) values[n + leaf] = leaves[leaf] = random.bits();
  std::multiset<std::uint32_t> calls;
  refit(n, changed, scratch, [&](std::uint32_t h) {
    values[h] = combine(values[2 * h], values[2 * h + 1]);
    calls.insert(h);
  });
  RC_ASSERT(values == aggregate_all(leaves));
  const auto expected = ancestors(n, changed);
  RC_ASSERT(std::ranges::equal(calls, expected));
}

}  // namespace

TEST_CASE("refitting the nodes above any leaves equals a sweep over all, and calls each of them once") {
  std::vector<std::uint32_t> scratch;
  CHECK(rc::check([&] {
    Random random = any_random();
    std::vector<std::uint64_t> leaves(any_leaf_count(10));
    for (auto& leaf : leaves) leaf = random.bits();
    std::vector<std::uint32_t> changed = shuffled(random, std::uint32_t(leaves.size()));
    changed.resize(random.below(std::uint32_t(leaves.size()) + 1));
    check_refit(random, leaves, changed, scratch);
  }));
}

TEST_CASE("one leaf costs the depth of the tree, all leaves its inner nodes") {
  std::vector<std::uint32_t> scratch, all(65536);
  std::iota(all.begin(), all.end(), 0u);
  std::size_t calls = 0;
  const auto count = [&](std::uint32_t) { ++calls; };
  refit(65536, std::array{40000u}, scratch, count);
  CHECK(calls == 16);
  calls = 0;
  refit(65536, all, scratch, count);
  CHECK(calls == 65535);
}

TEST_CASE("no leaves, a tree of one leaf, and a leaf that is named twice") {
  std::vector<std::uint32_t> scratch;
  std::vector<std::uint32_t> calls;
  const auto record = [&](std::uint32_t h) { calls.push_back(h); };
  refit(0, {}, scratch, record);
  refit(8, {}, scratch, record);
  refit(1, std::array{0u}, scratch, record);
  CHECK(calls.empty());
  refit(4, std::array{3u, 3u}, scratch, record);
  CHECK(calls == std::vector<std::uint32_t>{3, 1});
}
