// The two formats, from bytes in memory. All throw Refusal, or the std::exception of a library.
#pragma once

#include <coppice/core/image.hpp>
#include <coppice/exr/read.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace coppice::exr {

bool is_exr(std::string_view bytes);
Image decode_exr(std::string_view bytes);
Channel decode_exr_channel(std::string_view bytes, const std::string& name);
std::vector<std::string> decode_exr_channel_names(std::string_view bytes);

bool is_hdr(std::string_view bytes);
Image decode_hdr(std::string_view bytes);

/// Refuses what no file of ours holds; sides may be any number that a header can state.
void check_dimensions(long long width, long long height);

}  // namespace coppice::exr
