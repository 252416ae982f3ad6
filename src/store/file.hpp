// Files as bytes.
#pragma once

#include <filesystem>
#include <span>

#include "contents.hpp"

namespace coppice::store {

/// Throws Refusal where there is no regular file that can be read.
Bytes read_bytes(const std::filesystem::path& path);

/// Under a temporary name beside `path`, flushed to the disk, then renamed: a reader sees the old file or the
/// new one, never a part. Throws Refusal, and then leaves nothing behind. What a crash left is not touched.
void write_whole(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace coppice::store
