// The first 512 bytes of a store, which HDF5 leaves to its user: they let a reader refuse a truncated or
// damaged file before the HDF5 library sees any of it, as that crashes on some.
#pragma once

#include <span>

#include "contents.hpp"

namespace coppice::store {

inline constexpr std::size_t envelope_size = 512;
inline constexpr std::uint32_t format_version = 1;

/// What a file holds.
enum class Kind : std::uint32_t { visibility = 0, room = 1 };

/// Fills in the first 512 bytes of a file. Precondition: it has as many.
void seal(std::span<std::byte> file, Kind kind = Kind::visibility);

/// What stands behind the envelope. Throws Refusal where the file is no store, is of another kind, version or
/// length, or does not have its checksum: CRC-32, which finds every error of up to 32 neighbouring bits.
std::span<const std::byte> unseal(std::span<const std::byte> file, Kind kind = Kind::visibility);

}  // namespace coppice::store
