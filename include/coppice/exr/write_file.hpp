// A file that is either written whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace coppice {

/// Writes the bytes under a temporary name in the directory of `path`, then renames: a reader sees the old
/// file or the new one, never a part, and a failure leaves nothing behind. A link is followed, so that it
/// goes on linking. Throws InputError naming the path where the directory is missing or not writable, the
/// disk is full, or `path` exists and is no regular file.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace coppice
