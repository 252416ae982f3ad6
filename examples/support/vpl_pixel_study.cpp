#include <coppice/exr/exposure.hpp>
#include <coppice/exr/tone_map.hpp>
#include <coppice/trade/psnr.hpp>
#include <support/report.hpp>
#include <support/vpl_pixel_study.hpp>

namespace coppice::program {

namespace {

class Study {
 public:
  Study(const VplSubject& s, const VplTree& tree, const GatherSetting& setting, const EmbreeTracer& tracer)
      : s_(s),
        tree_(tree),
        setting_(setting),
        tracer_(tracer),
        point_of_(s.raster.pixel_count()),
        buffer_(g_buffer_of(s.scene, s.camera, s.raster, s.hits, s.points)) {
    for (std::uint32_t i = 0; i < s.points.size(); ++i) point_of_[s.points[i].pixel] = i;
    full_ = image_of(gather(s.points));
    exposure_ = automatic_exposure(full_, coverage());
  }

  PixelMeasurement measure(const AdaptiveOptions& options, std::span<const vec3> reference, int repeat) {
    PixelMeasurement row{{setting_}};
    std::vector<double> times;
    AdaptiveImage image;
    for (int i = 0; i < repeat; ++i) {
      nodes_.clear(), tests_ = 0;
      Stopwatch watch;
      image = sample_adaptively(
          buffer_, options,
          [&](std::span<const std::uint32_t> pixels, std::span<vec3> radiance) {
            std::vector<GlossyPoint> points;
            for (const std::uint32_t p : pixels) points.push_back(s_.points[point_of_[p]]);
            std::ranges::copy(gather(points), radiance.begin());
          },
          Serial{});
      times.push_back(1e6 * watch.lap() / double(s_.points.size()));
    }
    const CountSummary summary = summary_of(nodes_);
    row.gather.least = summary.min, row.gather.most = summary.max, row.gather.mean = summary.mean;
    row.gather.tests = double(tests_) / double(std::max<std::size_t>(1, nodes_.size()));
    row.gather.microseconds = median(times);
    row.share = double(image.samples) / double(s_.points.size());
    row.psnr = psnr(displayed(image.radiance), displayed(full_), counted());
    std::vector<vec3> values;
    for (const GlossyPoint& p : s_.points) values.push_back(image.radiance.pixels[p.pixel]);
    row.gather.errors = point_errors(values, reference);
    row.gather.bias = relative_bias(values, reference);
    return row;
  }

 private:
  std::vector<vec3> gather(std::span<const GlossyPoint> points) {
    std::vector<std::uint32_t> nodes;
    std::size_t tests = 0;
    auto radiance = gather_at(s_, tree_, points, setting_, tracer_, nodes, tests,
                              scattered_groups(points.size(), s_.points.size()));
    nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    tests_ += tests;
    return radiance;
  }
  Image image_of(std::span<const vec3> values) const {
    Image image(s_.raster.width, s_.raster.height);
    for (std::size_t i = 0; i < values.size(); ++i) image.pixels[s_.points[i].pixel] = values[i];
    return image;
  }
  std::vector<bool> counted() const {
    std::vector<bool> counts(s_.raster.pixel_count(), false);
    for (const GlossyPoint& p : s_.points) counts[p.pixel] = true;
    return counts;
  }
  std::vector<float> coverage() const {
    std::vector<float> covered(s_.raster.pixel_count(), 0);
    for (const GlossyPoint& p : s_.points) covered[p.pixel] = 1;
    return covered;
  }
  /// As the preview shows it, in [0, 1].
  Image displayed(Image image) const {
    for (vec3& p : image.pixels) {
      const vec3 shown = tone_map(p, exposure_);
      p = {srgb_encode(shown.x), srgb_encode(shown.y), srgb_encode(shown.z)};
    }
    return image;
  }

  const VplSubject& s_;
  const VplTree& tree_;
  GatherSetting setting_;
  const EmbreeTracer& tracer_;
  std::vector<std::uint32_t> point_of_, nodes_;
  GBuffer buffer_;
  Image full_;
  float exposure_ = 1;
  std::size_t tests_ = 0;
};

}  // namespace

std::vector<PixelMeasurement> measure_pixels(const VplSubject& subject, const VplTree& tree,
                                             const GatherSetting& setting, const EmbreeTracer& tracer,
                                             std::span<const AdaptiveOptions> ways,
                                             std::span<const vec3> reference, int repeat) {
  if (ways.empty()) return {};
  Study study(subject, tree, setting, tracer);
  std::vector<PixelMeasurement> measured;
  for (const AdaptiveOptions& way : ways) measured.push_back(study.measure(way, reference, repeat));
  return measured;
}

}  // namespace coppice::program
