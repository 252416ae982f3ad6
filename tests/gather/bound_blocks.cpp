// Where the bounds of nodes lie: every node at one place, and every place found again.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/gather/group_cut.hpp>

#include "gather/vpls.hpp"

using namespace coppice;

namespace {

std::uint32_t level_of(std::uint32_t h) { return std::uint32_t(std::bit_width(h)) - 1; }

/// The nearest ancestor with a block: the root, or one a multiple of three levels above the leaves.
std::uint32_t owner_of(std::uint32_t h, std::uint32_t depth) {
  do h /= 2;
  while (h > 1 && (depth - level_of(h)) % 3 != 0);
  return h;
}

/// Plain: places of which every ancestor in the block, from the second on, is split.
std::uint32_t reached_by_walk(std::uint32_t split) {
  std::uint32_t reached = 0;
  for (std::uint32_t place = 2; place < 16; ++place) {
    bool is_reached = true;
    for (std::uint32_t above = place / 2; above > 1; above /= 2) is_reached &= (split >> above & 1) != 0;
    reached |= std::uint32_t(is_reached) << place;
  }
  return reached;
}

}  // namespace

TEST_CASE("every node but the root has one place of one block, and is found there") {
  for (std::uint32_t depth = 0; depth <= 15; ++depth) {
    CAPTURE(depth);
    const std::uint32_t leaves = 1u << depth;
    const BlockLayout layout(leaves);
    std::vector<bool> is_taken(layout.block_count() * BlockLayout::places);
    std::size_t wrong = 0;
    for (std::uint32_t h = 2; h < 2 * leaves; ++h) {
      const auto [block, place] = layout.place_of(h);
      REQUIRE(block < layout.block_count());
      REQUIRE((place >= 2 && place < BlockLayout::places));
      wrong += is_taken[block * BlockLayout::places + place];
      is_taken[block * BlockLayout::places + place] = true;
      const std::uint32_t owner = owner_of(h, depth);
      wrong += layout.block_below(owner) != block;
      wrong += BlockLayout::node_at(owner, place) != h;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("all blocks but the root's are full, and there are no more than nodes need") {
  for (std::uint32_t depth = 1; depth <= 15; ++depth) {
    const std::size_t nodes = (std::size_t{2} << depth) - 2, blocks = BlockLayout(1u << depth).block_count();
    CHECK(blocks == (nodes + 13) / 14);
  }
  CHECK(BlockLayout(0).block_count() == 0);
  CHECK(BlockLayout(1).block_count() == 0);
}

TEST_CASE("the lowest places hold leaves and nodes with blocks of their own, no others") {
  for (std::uint32_t depth = 1; depth <= 12; ++depth) {
    const std::uint32_t leaves = 1u << depth;
    const BlockLayout layout(leaves);
    std::vector<std::uint32_t> lowest(leaves);
    for (std::uint32_t h = 2; h < 2 * leaves; ++h)
      if ((depth - level_of(h)) % 3 == 0) lowest[owner_of(h, depth)] |= 1u << layout.place_of(h).place;
    for (std::uint32_t h = 1; h < leaves; ++h)
      if (h == 1 || (depth - level_of(h)) % 3 == 0) CHECK(layout.lowest_places(h) == lowest[h]);
  }
}

TEST_CASE("places are reached where all above them in the block are split") {
  for (std::uint32_t split = 0; split < 1u << 16; ++split)
    if (detail::reached_places(split) != reached_by_walk(split)) FAIL_CHECK(split);
}

TEST_CASE("a block gives back the bounds that were set") {
  Random random(1);
  for (const std::uint32_t leaves : {2u, 4u, 8u, 16u, 128u}) {
    const auto vpls = support::wild_vpls(random, leaves);
    BoundBlocks blocks(leaves);
    std::vector<VplBound> bounds(2 * leaves);
    for (std::uint32_t h = 2; h < 2 * leaves; ++h) {
      bounds[h] = bound_of_both(bound_of_leaf(vpls[random.below(leaves)]), bound_of_leaf(vpls[h % leaves]));
      blocks.set(h, bounds[h], float(h));
    }
    for (std::uint32_t h = 2; h < 2 * leaves; ++h) {
      const auto [block, place] = blocks.layout().place_of(h);
      const VplBoundLanes n = blocks.load(block, place / Lanes::width * Lanes::width);
      const auto value = [&](Lanes x) {
        float values[Lanes::width];
        x.store(values);
        return values[place % Lanes::width];
      };
      const auto box = [&](const Lanes* x) { return vec3(value(x[0]), value(x[1]), value(x[2])); };
      const VplBound& b = bounds[h];
      CHECK((box(n.low) == b.low && box(n.high) == b.high));
      CHECK((box(n.normal_low) == b.normal_low && box(n.normal_high) == b.normal_high));
      CHECK((box(n.lobe_low) == b.lobe_low && box(n.lobe_high) == b.lobe_high));
      CHECK((value(n.slowest) == b.slowest && value(n.peak) == b.peak && value(n.diffuse) == b.diffuse));
      CHECK((value(n.softening) == b.softening && value(n.size) == float(h)));
    }
  }
}
