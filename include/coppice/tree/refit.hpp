// Brings an aggregate up to date after some leaves have changed.
#pragma once

#include <algorithm>
#include <coppice/core/config.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// Calls recompute(h) once for every inner node above the given leaves (ranks, in any order), children before
/// their parents. What it computes from values[2h] and values[2h + 1] alone then equals a sweep over the
/// whole tree (aggregate.hpp), bit for bit. Cost: at most leaves · log2(leaf_count) calls; `scratch` is
/// memory to be reused.
template <class Recompute>
void refit(std::uint32_t leaf_count, std::span<const std::uint32_t> leaves,
           std::vector<std::uint32_t>& scratch, Recompute&& recompute) {
  scratch.clear();
  for (const std::uint32_t leaf : leaves) {
    COPPICE_ASSERT(leaf < leaf_count);
    scratch.push_back(leaf_count + leaf);
  }
  std::ranges::sort(scratch);
  while (!scratch.empty() && scratch.front() > 1) {
    for (std::uint32_t& h : scratch) h /= 2;
    scratch.erase(std::unique(scratch.begin(), scratch.end()), scratch.end());
    for (const std::uint32_t h : scratch) recompute(h);
  }
}

}  // namespace coppice
