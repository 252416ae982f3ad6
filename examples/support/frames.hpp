// The frames of a program: their files, and what each is compared with.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <support/system.hpp>

namespace coppice::program {

/// The PNG beside an image.
std::filesystem::path preview_path(std::filesystem::path image);

/// Throws InputError where the images of the frames, their previews or the report (empty: none) could not be
/// written.
void require_frames_writable(const std::filesystem::path& out, int frames,
                             const std::filesystem::path& report);

/// What frames are compared with. Names are those of RenderedFrame::parts; empty is the whole image.
struct Comparisons {
  bool reference = false;    ///< with System::reference, which becomes a layer, as does the difference
  std::string referenced{};  ///< the part that it is a reference of
  Image image{};             ///< that of --compare; without pixels none
  int block = 1;             ///< compare means over block × block pixels with it
  std::string compared{};    ///< the part that is compared with it
};

/// Renders frames, compares them and writes their files: colour, coverage A, cut_size.Y and all parts as EXR
/// layers, and a preview at the first frame's exposure, so that an animation does not flicker.
class FrameWriter {
 public:
  /// `out` becomes out.exr of the only frame, of several out.0007.exr. The system outlives it.
  FrameWriter(System& system, std::filesystem::path out, int frames, Comparisons comparisons)
      : system_(system), out_(std::move(out)), frames_(frames), comparisons_(std::move(comparisons)) {}

  /// All frames, each told on stderr by `print(number, report of the frame)`. Returns their reports.
  template <class Print>
  nlohmann::json write_all(Print&& print) {
    nlohmann::json reports = nlohmann::json::array();
    for (int number = 0; number < frames_; ++number) {
      reports.push_back(write(number));
      print(number, reports.back());
    }
    return reports;
  }

 private:
  nlohmann::json write(int number);
  void compare_all(RenderedFrame& frame);
  float exposure(const RenderedFrame& frame);

  System& system_;
  std::filesystem::path out_;
  int frames_;
  Comparisons comparisons_;
  std::optional<float> exposure_;
};

}  // namespace coppice::program
