#include <algorithm>
#include <coppice/core/error.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/exr/write_file.hpp>
#include <numeric>
#include <support/report.hpp>

namespace coppice::program {

using nlohmann::json;

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
          {"brdf", word_of(shading_words, c.shading)},
          {"lights", o.lights},
          {"max_cut_size", o.max_cut_size},
          {"receiver_tolerance", o.receiver_tolerance},
          {"max_receivers", o.max_receivers},
          {"receivers", word_of(scope_words, o.receivers)},
          {"longest_edge", o.longest_edge},
          {"beta", o.beta},
          {"lobe_tolerance", o.lobe_tolerance},
          {"instructions", word_of(instruction_words, o.instructions)}};
}

json preparation_json(const CutRelighting<>& relighting, const Scene& scene) {
  const PreparationReport& r = relighting.report();
  return {{"triangles", scene.mesh.triangles.size()},
          {"instructions", relighting.kernels().instructions},
          {"lights", relighting.directions().size()},
          {"receivers", r.receivers},
          {"receivers_before_refinement", r.unrefined_receivers},
          {"shadow_rays", r.rays},
          {"pilot_receivers", r.pilot_receivers},
          {"pilot_rays", r.pilot_rays},
          {"shading_points", relighting.buffer().points.size()},
          {"shading_faces", relighting.buffer().faces.size()},
          {"seconds",
           {{"tree", r.tree},
            {"camera", r.camera},
            {"refinement", r.refinement},
            {"pilots", r.pilots},
            {"data_driven_tree", r.data_driven_tree},
            {"visibility", r.visibility}}}};
}

CountSummary summary_of(std::span<const std::uint32_t> counts) {
  if (counts.empty()) return {};
  const auto [low, high] = std::ranges::minmax(counts);
  return {low, high, std::accumulate(counts.begin(), counts.end(), 0.0) / double(counts.size())};
}

json summary_json(const CountSummary& s) { return {{"min", s.min}, {"mean", s.mean}, {"max", s.max}}; }

json errors_json(const ImageErrors& e) {
  return {{"rel_rmse", e.rel_rmse}, {"mre", e.mre}, {"rel_mse", e.rel_mse},
          {"p95", e.p95},           {"p99", e.p99}, {"pixels", e.pixels}};
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
