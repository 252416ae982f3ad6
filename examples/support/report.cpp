#include <algorithm>
#include <coppice/core/error.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/exr/write_file.hpp>
#include <support/report.hpp>

namespace coppice::program {

using nlohmann::json;

namespace {
const char* brdf_name(Shading shading) {
  switch (shading) {
    case Shading::metallic_roughness:
      return "gltf";
    case Shading::lambert:
      return "lambert";
    case Shading::phong:
      return "phong";
    case Shading::blinn_phong:
      return "blinn-phong";
    case Shading::ward:
      return "ward";
  }
  return "";
}
}  // namespace

json settings_json(const CommonOptions& c, const CutOptions& o) {
  return {{"scene", c.scene.string()},
          {"environment", c.environment.string()},
          {"width", c.raster.width},
          {"height", c.raster.height},
          {"samples", c.raster.samples},
          {"rotate_env_degrees", c.rotate_environment},
          {"backend", c.backend},
          {"threads", c.threads},
          {"seed", c.seed},
          {"brdf", brdf_name(c.shading)},
          {"lights", o.lights},
          {"max_cut_size", o.max_cut_size},
          {"receiver_tolerance", o.receiver_tolerance},
          {"max_receivers", o.max_receivers},
          {"receivers", o.receivers == ReceiverScope::seen ? "seen" : "all"}};
}

json preparation_json(const CutRelighting<>& relighting, const Scene& scene) {
  const PreparationReport& r = relighting.report();
  return {
      {"triangles", scene.mesh.triangles.size()},
      {"lights", relighting.directions().size()},
      {"receivers", r.receivers},
      {"receivers_before_refinement", r.unrefined_receivers},
      {"shadow_rays", r.rays},
      {"shading_points", relighting.buffer().points.size()},
      {"shading_faces", relighting.buffer().faces.size()},
      {"seconds",
       {{"tree", r.tree}, {"camera", r.camera}, {"refinement", r.refinement}, {"visibility", r.visibility}}}};
}

json cuts_json(const MaskedCuts<std::uint8_t>& cuts) {
  std::size_t low = cuts.size() == 0 ? 0 : cuts.piece_count(0), high = 0;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    low = std::min(low, cuts.piece_count(i));
    high = std::max(high, cuts.piece_count(i));
  }
  const double mean = cuts.size() == 0 ? 0 : double(cuts.values().size()) / double(cuts.size());
  return {{"min", low}, {"mean", mean}, {"max", high}, {"bytes", cuts.byte_count()}};
}

json errors_json(const ImageErrors& e) {
  return {
      {"rel_rmse", e.rel_rmse}, {"mre", e.mre}, {"rel_mse", e.rel_mse}, {"p99", e.p99}, {"pixels", e.pixels}};
}

std::vector<bool> counted_pixels(const DirectImage& direct) {
  std::vector<bool> counts(direct.coverage.size());
  for (std::size_t i = 0; i < counts.size(); ++i)
    counts[i] = direct.coverage[i] > 0 && direct.emission.pixels[i] == vec3(0);
  return counts;
}

ImageErrors compare(const Image& image, const Image& reference, const std::vector<bool>& counts, int block) {
  if (block <= 1) return image_errors(image, reference, counts);
  std::vector<bool> block_counts;
  const Image x = block_means(image, counts, block, block_counts);
  return image_errors(x, block_means(reference, counts, block, block_counts), block_counts);
}

Image read_comparison(const std::filesystem::path& path, const Raster& raster) {
  Image image = read_image(path);
  if (image.width != raster.width || image.height != raster.height)
    throw InputError(path.string(), "is " + std::to_string(image.width) + "x" + std::to_string(image.height),
                     "render with that --size to compare");
  return image;
}

void write_report(const std::filesystem::path& path, const json& report) {
  write_file(path, report.dump(2) + "\n");
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace coppice::program
