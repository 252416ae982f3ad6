// Visibility on disk: an HDF5 file that h5py reads too. Layout and format version: docs/store.md.
#pragma once

#include <coppice/store/stored_visibility.hpp>
#include <filesystem>

namespace coppice {

/// Writes the file whole or not at all: under a temporary name in the same folder, flushed to the disk, then
/// renamed. Throws InputError naming the path where the folder is missing or not writable, the disk is full,
/// or `path` exists and is no regular file; and where the content breaks an invariant that a reader would
/// refuse. Equal content gives equal files. About 1 s for 20 MB of masks.
template <Quantised Value>
void write_store(const std::filesystem::path& path, const StoredVisibility<Value>& visibility);

/// Reads and checks everything. Throws InputError naming the file, the item, what is wrong and what to do,
/// where the file is missing, truncated or damaged, of another format version, holds values of another width,
/// or describes what cannot be. Takes memory only where the compressed bytes that are there can fill it. What
/// comes back equals what was written, but for Receiver::inward and, to 1e-6, the normals of corners at
/// middles of edges.
template <Quantised Value>
StoredVisibility<Value> read_store(const std::filesystem::path& path);

/// The settings alone; cost: reading the file. Throws as read_store.
Settings read_settings(const std::filesystem::path& path);

extern template void write_store(const std::filesystem::path&, const StoredVisibility<std::uint8_t>&);
extern template void write_store(const std::filesystem::path&, const StoredVisibility<std::uint16_t>&);
extern template StoredVisibility<std::uint8_t> read_store(const std::filesystem::path&);
extern template StoredVisibility<std::uint16_t> read_store(const std::filesystem::path&);

}  // namespace coppice
