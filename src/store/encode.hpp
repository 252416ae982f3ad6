// From visibility to the counts and arrays of a store, and back.
#pragma once

#include <coppice/store/stored_visibility.hpp>

#include "contents.hpp"
#include "hdf5_file.hpp"

namespace coppice::store {

/// Throws Refusal where a file of these contents would be refused.
template <Quantised Value>
Contents encode(const StoredVisibility<Value>& visibility);

/// Throws Refusal naming the item that is not as it must be.
template <Quantised Value>
StoredVisibility<Value> decode(Hdf5Reader& reader);

Settings decode_settings(Hdf5Reader& reader);

/// Receivers whose values are compressed together; the other arrays have blocks of as many rows.
inline constexpr std::size_t block_of_receivers = 1024;

}  // namespace coppice::store
