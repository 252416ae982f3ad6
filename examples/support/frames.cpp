#include <algorithm>
#include <coppice/core/error.hpp>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/write.hpp>
#include <support/frames.hpp>
#include <support/report.hpp>

namespace coppice::program {

namespace {

std::filesystem::path frame_path(const std::filesystem::path& out, int frames, int frame) {
  std::filesystem::path path = out;
  if (frames == 1) return path;
  std::string number = std::to_string(frame);
  number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
  return path.replace_extension("." + number + path.extension().string());
}

/// The part of that name, or the whole image.
const Image& part_of(const RenderedFrame& frame, const std::string& name) {
  if (name.empty()) return frame.image;
  return std::ranges::find(frame.parts, name, [](const auto& part) { return part.first; })->second;
}

}  // namespace

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

nlohmann::json FrameWriter::write(int number) {
  RenderedFrame frame = system_.render(number);
  compare_all(frame);
  std::vector<Layer> layers{{"", frame.image}, {"A", frame.direct.coverage}, {"cut_size.Y", frame.cut_size}};
  for (const auto& [name, image] : frame.parts) layers.push_back({name, image});
  const std::filesystem::path path = frame_path(out_, frames_, number);
  write_exr(path, frame.image.width, frame.image.height, layers);
  write_png(preview_path(path), frame.image, exposure(frame));
  return frame.report;
}

void FrameWriter::compare_all(RenderedFrame& frame) {
  const auto counts = counted_pixels(frame.direct);
  if (!comparisons_.image.pixels.empty())
    frame.report["compared"] = errors_json(
        compare(part_of(frame, comparisons_.compared), comparisons_.image, counts, comparisons_.block));
  if (!comparisons_.reference) return;
  Image reference = system_.reference(frame.report), error = part_of(frame, comparisons_.referenced);
  frame.report["errors"] = errors_json(compare(error, reference, counts, 1));
  for (std::size_t i = 0; i < error.pixels.size(); ++i) error.pixels[i] -= reference.pixels[i];
  frame.parts.emplace_back("reference", std::move(reference));
  frame.parts.emplace_back("error", std::move(error));
}

float FrameWriter::exposure(const RenderedFrame& frame) {
  if (!exposure_) exposure_ = automatic_exposure(frame.image, frame.direct.coverage);
  return *exposure_;
}

}  // namespace coppice::program
