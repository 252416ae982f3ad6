// The files of a program's frames.
#pragma once

#include <filesystem>

namespace coppice::program {

/// out.exr of the only frame; of several out.0007.exr.
std::filesystem::path frame_path(const std::filesystem::path& out, int frames, int frame);

/// The PNG beside an image.
std::filesystem::path preview_path(std::filesystem::path image);

/// Throws InputError where the images of the frames, their previews or the report (empty: none) could not be
/// written.
void require_frames_writable(const std::filesystem::path& out, int frames,
                             const std::filesystem::path& report);

}  // namespace coppice::program
