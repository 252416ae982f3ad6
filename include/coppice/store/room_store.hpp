// A prepared room on disk: an HDF5 file that h5py reads too. Layout and format version: docs/store.md.
#pragma once

#include <coppice/store/stored_room.hpp>
#include <filesystem>

namespace coppice {

/// Writes the file whole or not at all, as write_store does. Throws InputError naming the path where it
/// cannot be written, and where the room breaks an invariant of StoredRoom. Equal rooms give equal files.
/// About 0.5 s for 10 MB.
void write_room(const std::filesystem::path& path, const StoredRoom& room);

/// Reads and checks everything. Throws InputError naming the file, the item, what is wrong and what to do,
/// where the file is missing, truncated or damaged, of another version, a store of something else, or
/// describes what cannot be. Takes memory only where the compressed bytes that are there can fill it. What
/// comes back equals what was written, bit for bit.
StoredRoom read_room(const std::filesystem::path& path);

/// The settings alone; cost: reading the file. Throws as read_room.
Settings read_room_settings(const std::filesystem::path& path);

}  // namespace coppice
