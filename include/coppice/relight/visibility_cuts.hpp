// Precomputed visibility: from shadow rays to the cuts of every receiver.
#pragma once

#include <coppice/core/parallel.hpp>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/visibility.hpp>
#include <coppice/relight/visibility_cut_selector.hpp>
#include <coppice/relight/visibility_rows.hpp>
#include <functional>
#include <numeric>
#include <span>
#include <vector>

namespace coppice {

/// Told between blocks how many receivers of how many are done.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

/// Calls consume(receiver index, row of bits) for every receiver on the executor's threads, in blocks of
/// `visibility_block`; after each block end_of_block(first, count) is called once. Each piece of work has a
/// copy of `consume`, which may keep scratch. Rows of `known` are not traced again. Returns the rays traced.
inline constexpr std::size_t visibility_block = 2048;

template <Occluder O, LightPackets L, Executor E, class Consume, class EndOfBlock>
std::size_t for_each_visibility(const O& occluder, const L& lights, std::span<const Receiver> receivers,
                                const E& executor, const Consume& consume, EndOfBlock&& end_of_block,
                                const VisibilityRows& known = {}) {
  std::vector<std::size_t> traced(receivers.size());
  for (std::size_t first = 0; first < receivers.size(); first += visibility_block) {
    const std::size_t count = std::min(visibility_block, receivers.size() - first);
    executor(count, 16, [&](std::size_t begin, std::size_t end) {
      std::vector<std::uint64_t> bits(words_for_bits(lights.count()));
      Consume consume_here = consume;
      for (std::size_t i = first + begin; i < first + end; ++i) {
        std::span<const std::uint64_t> row = known.find(i);
        if (row.empty()) {
          traced[i] = trace_visibility(occluder, lights, receivers[i], bits);
          row = bits;
        }
        consume_here(i, row);
      }
    });
    end_of_block(first, count);
  }
  return std::accumulate(traced.begin(), traced.end(), std::size_t{0});
}

/// Moves receivers that see nothing towards the middle of their faces, where something may be seen: a corner
/// that lies inside another object would darken faces that are half outside. Those that are dark there too
/// stay. `pilot`: few of the lights will do.
template <Occluder O, LightPackets L, Executor E>
void free_buried_receivers(const O& occluder, const L& pilot, std::span<Receiver> receivers,
                           const E& executor) {
  executor(receivers.size(), 64, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint64_t> bits(words_for_bits(pilot.count()));
    const auto sees_nothing = [&](const Receiver& r) {
      trace_visibility(occluder, pilot, r, bits);
      return std::ranges::all_of(bits, [](std::uint64_t word) { return word == 0; });
    };
    for (Receiver& receiver : receivers.subspan(begin, end - begin)) {
      Receiver moved = receiver;
      for (const float share : {0.25f, 0.5f, 0.75f}) {
        if (!sees_nothing(moved)) break;
        moved.position = receiver.position + share * receiver.inward;
      }
      if (!sees_nothing(moved)) receiver = moved;
    }
  });
}

/// What the precomputation leaves behind.
template <Quantised Value>
struct VisibilityCuts {
  std::vector<MaskedCuts<Value>> cuts;  ///< one store for each of the options, receivers in order
  std::vector<std::uint64_t>
      bits;              ///< all rows, words_for_bits(leaf count) words a receiver, where asked for
  std::size_t rays = 0;  ///< without those of rows that were known
};

/// Traces every receiver once and selects its cut for each of `options`. Only cuts are kept, unless keep_bits
/// asks for the dense rows too (leaf_count/8 bytes a receiver), as the brute-force twins need them. The
/// result does not depend on the executor. Rows of `known` are taken instead of traced. Precondition:
/// `leaf_lights` has one direction a leaf of the tree, `known` is in the order of its leaves.
template <Quantised Value, Occluder O, Executor E>
VisibilityCuts<Value> precompute_visibility(const O& occluder, const LightTree& tree,
                                            const DirectionPackets& leaf_lights,
                                            std::span<const Receiver> receivers,
                                            std::span<const VisibilityCutOptions> options, bool keep_bits,
                                            const E& executor, const Progress& progress = {},
                                            const VisibilityRows& known = {}) {
  COPPICE_ASSERT(leaf_lights.count() == tree.leaf_count());
  VisibilityCuts<Value> result;
  const std::size_t words = words_for_bits(tree.leaf_count());
  if (keep_bits) result.bits.resize(receivers.size() * words);
  std::vector<std::vector<Cut<Value>>> block(options.size(), std::vector<Cut<Value>>(visibility_block));
  std::vector<VisibilityCutSelector> selectors;
  for (const auto& o : options) {
    selectors.emplace_back(tree, leaf_lights, o);
    result.cuts.emplace_back(tree.leaf_count(), selectors.back().granule_log2());
  }
  const auto select = [&, selectors](std::size_t i, std::span<const std::uint64_t> bits) mutable {
    for (std::size_t o = 0; o < options.size(); ++o)
      block[o][i % visibility_block] =
          selectors[o].template select<Value>(bits, horizon_of(receivers[i], options[o].weight));
    if (keep_bits) std::ranges::copy(bits, result.bits.begin() + std::ptrdiff_t(i * words));
  };
  const auto store = [&](std::size_t first, std::size_t count) {
    for (std::size_t o = 0; o < options.size(); ++o)
      for (std::size_t i = 0; i < count; ++i)
        result.cuts[o].append(block[o][i], horizon_of(receivers[first + i], options[o].weight));
    if (progress) progress(first + count, receivers.size());
  };
  result.rays = for_each_visibility(occluder, leaf_lights, receivers, executor, select, store, known);
  return result;
}

}  // namespace coppice
