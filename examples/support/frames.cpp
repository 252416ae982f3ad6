#include <coppice/core/error.hpp>
#include <string>
#include <support/frames.hpp>
#include <support/program.hpp>

namespace coppice::program {

std::filesystem::path frame_path(const std::filesystem::path& out, int frames, int frame) {
  std::filesystem::path path = out;
  if (frames == 1) return path;
  std::string number = std::to_string(frame);
  number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
  return path.replace_extension("." + number + path.extension().string());
}

std::filesystem::path preview_path(std::filesystem::path image) { return image.replace_extension(".png"); }

void require_frames_writable(const std::filesystem::path& out, int frames,
                             const std::filesystem::path& report) {
  if (out == preview_path(out))
    throw InputError(out.string(), "is the name of the preview", "let --out end in .exr");
  for (const int frame : {0, frames - 1}) {
    require_writable(frame_path(out, frames, frame));
    require_writable(preview_path(frame_path(out, frames, frame)));
  }
  if (!report.empty()) require_writable(report);
}

}  // namespace coppice::program
