#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <stdexcept>
#include <support/measure.hpp>

namespace coppice::program {

namespace {

class Measurer {
 public:
  Measurer(CutRelighting<>& relighting, const Environment& environment, const MeasureOptions& options)
      : relighting_(relighting),
        environment_(environment),
        options_(options),
        counts_(counted_pixels(relighting.direct())) {}

  void repeat_twins(Twins& twins) {
    const FrameLighting frame = relighting_.light(environment_, 1);
    Stopwatch watch;
    const auto skipping = relighting_.shade_by_brute_force<Skip::unseen>(frame, Serial{});
    twins.skipping.push_back(1e3 * watch.lap());
    const auto plain = relighting_.shade_by_brute_force<Skip::nothing>(frame, Serial{});
    twins.plain.push_back(1e3 * watch.lap());
    const auto agrees = [](const vec3& a, const vec3& b) {
      return length(a - b) <= 1e-4f * (length(a) + length(b)) + 1e-12f;
    };
    if (!std::ranges::equal(skipping, plain, agrees))
      throw std::logic_error("the two brute-force twins disagree");
    if (twins.reference.pixels.empty()) twins.reference = relighting_.image(plain);
  }

  void repeat_point(OperatingPoint& p, const Image& reference) {
    std::vector<std::uint32_t> clusters(relighting_.buffer().points.size());
    Stopwatch watch;
    const FrameLighting frame = relighting_.light(environment_, p.knobs.nodes, p.which);
    p.lighting.push_back(1e3 * watch.lap());
    const auto radiance =
        relighting_.shade(frame, Serial{}, p.which, clusters, {p.knobs.lobes, options_.lobe_tolerance});
    p.shading.push_back(1e3 * watch.lap());
    if (p.shading.size() > 1) return;  // what is not a time is the same each time
    p.illumination_nodes = frame.ends.size();
    p.clusters = summary_of(clusters);
    const Image image = relighting_.image(radiance);
    p.errors = image_errors(image, reference, counts_);
    if (options_.keep_images) p.image = image;
  }

  /// relRMSE of a set of visibility cuts under all lights, each at its own direction.
  double visibility_error(std::size_t which, const Image& reference) {
    const FrameLighting frame = relighting_.light(environment_, relighting_.tree().leaf_count(), which);
    const auto radiance = relighting_.shade(frame, Serial{}, which, {}, {Lobes::sampled});
    return image_errors(relighting_.image(radiance), reference, counts_).rel_rmse;
  }

 private:
  CutRelighting<>& relighting_;
  const Environment& environment_;
  const MeasureOptions& options_;
  std::vector<bool> counts_;
};

void measure_visibility(Measurer& measurer, Measurements& measured, std::size_t sets) {
  for (std::size_t which = 0; which < sets; ++which) {
    std::fprintf(stderr, "visibility alone, %zu of %zu sets of cuts\n", which + 1, sets);
    const double error = measurer.visibility_error(which, measured.twins.reference);
    for (auto& p : measured.points)
      if (p.which == which) p.visibility_rel_rmse = error;
  }
}

/// The admitted point of least value.
template <class Admits, class Value>
const OperatingPoint* least(std::span<const OperatingPoint> points, const Admits& admits,
                            const Value& value) {
  const OperatingPoint* best = nullptr;
  for (const auto& p : points)
    if (admits(p) && (!best || value(p) < value(*best))) best = &p;
  return best;
}

double error_of(const OperatingPoint& p) { return p.errors.rel_rmse; }
double time_of(const OperatingPoint& p) { return p.milliseconds(); }

}  // namespace

std::vector<VisibilityCutOptions> share_cuts(std::vector<OperatingPoint>& points, const CutOptions& options) {
  std::vector<VisibilityCutOptions> sets;
  for (auto& p : points) {
    const auto found = std::ranges::find_if(sets, [&](const VisibilityCutOptions& set) {
      return set.sigma == p.knobs.sigma && CutKind{set.weight, set.search} == p.knobs.cuts;
    });
    p.which = std::size_t(found - sets.begin());
    if (found == sets.end()) sets.push_back(visibility_options(options, p.knobs.sigma, p.knobs.cuts));
  }
  return sets;
}

Measurements measure(std::vector<OperatingPoint> points, CutRelighting<>& relighting,
                     const Environment& environment, const MeasureOptions& options) {
  Measurements measured{std::move(points), {}};
  Measurer measurer(relighting, environment, options);
  for (int round = 0; round < options.repeat; ++round) {
    std::fprintf(stderr, "measuring, round %d of %d\n", round + 1, options.repeat);
    measurer.repeat_twins(measured.twins);
    for (auto& p : measured.points) measurer.repeat_point(p, measured.twins.reference);
  }
  if (options.visibility_only) measure_visibility(measurer, measured, relighting.options().cuts.size());
  return measured;
}

const OperatingPoint* cheapest(std::span<const OperatingPoint> points, double error) {
  return least(
      points, [&](const auto& p) { return error_of(p) <= error; }, time_of);
}

const OperatingPoint* most_accurate(std::span<const OperatingPoint> points, double milliseconds) {
  return least(
      points, [&](const auto& p) { return time_of(p) <= milliseconds; }, error_of);
}

}  // namespace coppice::program
