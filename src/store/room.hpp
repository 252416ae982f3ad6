// From a prepared room to the counts and arrays of a store, and back.
#pragma once

#include <coppice/store/stored_room.hpp>

#include "contents.hpp"
#include "hdf5_file.hpp"

namespace coppice::store {

/// Throws Refusal where a file of these contents would be refused.
Contents encode(const StoredRoom& room);

/// Throws Refusal naming the item that is not as it must be.
StoredRoom decode_room(Hdf5Reader& reader);

/// The rows of which the bits of a cluster's feature index tell: none where there are no lattice points.
inline std::uint64_t row_count(std::span<const std::uint32_t> bits) {
  std::uint64_t rows = bits.empty() ? 0 : 1;
  for (const std::uint32_t word : bits) rows += std::uint64_t(std::popcount(word));
  return rows;
}

/// An index of these bits.
inline FeatureIndex index_of(std::vector<std::uint32_t> bits) {
  FeatureIndex index{std::move(bits), {}};
  std::uint32_t before = 0;
  for (const std::uint32_t word : index.bits) {
    index.before.push_back(before);
    before += std::uint32_t(std::popcount(word));
  }
  return index;
}

/// Throws Refusal with `start` and what is wrong where the room breaks an invariant, but for floats that are
/// not finite.
void require_invariants(const StoredRoom& room, const std::string& start, const std::string& remedy);

}  // namespace coppice::store
