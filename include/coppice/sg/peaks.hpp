// The bright lights of an environment map as a few Gaussians.
#pragma once

#include <coppice/shared/sg.h>

#include <algorithm>
#include <array>
#include <coppice/sg/bright_regions.hpp>
#include <cstddef>
#include <limits>

namespace coppice {

/// What counts as a peak, and how many Gaussians stand for one.
struct PeakOptions {
  /// Regions brighter than this multiple of the map's mean luminance are peaks. > 1; 4 to 16 are safe.
  float threshold = 8;
  /// Gaussians of all peaks together; the regions of most energy come first. 0: no peaks.
  std::size_t most = 32;
  /// Gaussians of one peak at most, 1 to 3: long ones get more.
  int per_peak = 3;
  /// Regions of less than this share of the map's energy are no peaks. 0: all are.
  float least_share = 0;
};

/// The light of that shape and amplitude, with SgLight::luminance filled in.
inline SgLight sg_light(const SgShape& shape, const vec3& amplitude) {
  return {shape.axis, shape.sharpness, amplitude,
          luminance(glm::abs(amplitude)) * sg_integral(shape.sharpness)};
}

/// The light of that shape and energy (radiance · steradians, linear RGB).
inline SgLight sg_light_of_energy(const SgShape& shape, const glm::dvec3& energy) {
  return sg_light(shape, vec3(energy / double(sg_integral(shape.sharpness))));
}

/// Σ amplitude · integral, in double: the energy of lights, for all that they may cancel.
inline glm::dvec3 sg_energy(std::span<const SgLight> lights) {
  glm::dvec3 sum(0);
  for (const SgLight& light : lights)
    sum += double(sg_integral(light.sharpness)) * glm::dvec3(light.amplitude);
  return sum;
}

}  // namespace coppice

namespace coppice::detail {

/// Directions of a map's rows and columns, apart.
class TexelFrame {
 public:
  TexelFrame(int width, int height) {
    for (int x = 0; x < width; ++x) {
      const double azimuth = 2 * std::numbers::pi * ((x + 0.5) / width - 0.5);
      columns_.push_back({std::cos(azimuth), std::sin(azimuth)});
    }
    for (int y = 0; y < height; ++y) {
      const double elevation = std::numbers::pi * (0.5 - (y + 0.5) / height), c = std::cos(elevation);
      const double across = 2 * std::numbers::pi / width * c, down = std::numbers::pi / height;
      rows_.push_back({c, std::sin(elevation), texel_solid_angle(y, width, height),
                       (across * across + down * down) / 24});
    }
  }
  glm::dvec3 direction(int x, int y) const {
    const Row& row = rows_[std::size_t(y)];
    const glm::dvec2& column = columns_[std::size_t(x)];
    return {row.cosine * column.x, row.sine, row.cosine * column.y};
  }
  double solid_angle(int y) const { return rows_[std::size_t(y)].solid_angle; }
  /// 1 - the length of the mean of a texel's directions, to its second moments: (width² + height²)/24.
  double shortfall(int y) const { return rows_[std::size_t(y)].shortfall; }

 private:
  struct Row {
    double cosine, sine, solid_angle, shortfall;
  };
  std::vector<glm::dvec2> columns_;
  std::vector<Row> rows_;
};

/// Sums over texels that a Gaussian is matched to.
struct PeakMoments {
  double weight = 0;         ///< Σ luminance · solid angle
  double shortfall = 0;      ///< the same, times each texel's own
  glm::dvec3 directions{0};  ///< the same, times the direction
  glm::dvec3 energy{0};

  void add(const TexelFrame& frame, int x, int y, const vec3& radiance) {
    const double w = frame.solid_angle(y) * double(luminance(radiance));
    weight += w;
    shortfall += w * frame.shortfall(y);
    directions += w * frame.direction(x, y);
    energy += frame.solid_angle(y) * glm::dvec3(radiance);
  }

  /// The Gaussian of the same mean direction, of the same length, and of the same energy.
  SgLight light() const {
    const double size = glm::length(directions), r = size / weight;
    const vec3 axis = size > 1e-12 * weight ? vec3(directions / size) : vec3(0, 1, 0);
    const double q = std::clamp(1 - r, 0.0, 1.0) + r * shortfall / weight;
    const double narrow = std::clamp(q, 1e-10, 1.0);
    return sg_light_of_energy({axis, sg_sharpness_of_mean(float(1 - narrow), float(narrow))}, energy);
  }
};

/// Calls visit(column, row, radiance) for each texel of the runs.
template <class Visit>
void for_each_texel(const Image& map, std::span<const BrightRun> runs, Visit&& visit) {
  for (const BrightRun& run : runs)
    for (int x = run.begin; x < run.end; ++x) visit(x, run.row, map.at(x, run.row));
}

/// The axis along which a region is longest, as a tangent to the sphere whose length is the standard
/// deviation along it; and the ratio of the variances along and across.
struct PeakExtent {
  glm::dvec3 along{0};
  double ratio = 1;
};

inline PeakExtent peak_extent(const Image& map, std::span<const BrightRun> runs, const TexelFrame& frame,
                              const PeakMoments& moments) {
  vec3 tangent, bitangent;
  make_frame(moments.light().axis, tangent, bitangent);
  const glm::dvec3 u(tangent), v(bitangent);
  const double own = moments.shortfall / moments.weight;  // the variance of a texel along each axis
  double uu = own, uv = 0, vv = own;
  for_each_texel(map, runs, [&](int x, int y, const vec3& radiance) {
    const double w = frame.solid_angle(y) * double(luminance(radiance)) / moments.weight;
    const glm::dvec3 d = frame.direction(x, y);
    const double a = glm::dot(d, u), b = glm::dot(d, v);
    uu += w * a * a, uv += w * a * b, vv += w * b * b;
  });
  const double middle = (uu + vv) / 2, apart = std::hypot((uu - vv) / 2, uv);
  const double angle = std::atan2(2 * uv, uu - vv) / 2;
  const double longest = middle + apart, shortest = std::max(middle - apart, 1e-300);
  return {std::sqrt(longest) * (std::cos(angle) * u + std::sin(angle) * v), longest / shortest};
}

/// One to three Gaussians: the region is cut across where it is long. A bar of even light has the length of
/// √12 of its deviation, thirds of which end at ±0.577.
inline void append_peak(const Image& map, std::span<const BrightRun> runs, const TexelFrame& frame,
                        std::size_t most, std::vector<SgLight>& lights) {
  PeakMoments whole;
  for_each_texel(map, runs, [&](int x, int y, const vec3& radiance) { whole.add(frame, x, y, radiance); });
  const PeakExtent extent = most > 1 ? peak_extent(map, runs, frame, whole) : PeakExtent{};
  const std::size_t count = std::min<std::size_t>(most, extent.ratio > 6 ? 3 : extent.ratio > 2.5 ? 2 : 1);
  if (count == 1) {
    lights.push_back(whole.light());
    return;
  }
  std::array<PeakMoments, 3> parts;
  const double cut = count == 3 ? 0.577 : 0, variance = glm::dot(extent.along, extent.along);
  const glm::dvec3 mean = whole.directions / whole.weight;
  for_each_texel(map, runs, [&](int x, int y, const vec3& radiance) {
    const double place = glm::dot(frame.direction(x, y) - mean, extent.along) / variance;
    const std::size_t part = place < -cut ? 0 : place < cut || count == 2 ? 1 : 2;
    parts[part].add(frame, x, y, radiance);
  });
  for (const PeakMoments& part : parts)
    if (part.weight > 0) lights.push_back(part.light());
}

/// Σ luminance of the lights from `first` on.
inline double luminance_from(std::span<const SgLight> lights, std::size_t first) {
  double sum = 0;
  for (const SgLight& light : lights.subspan(first)) sum += double(light.luminance);
  return sum;
}

/// The regions of most energy, each with its runs together.
inline std::vector<std::vector<BrightRun>> brightest_regions(const Image& map, const BrightRegions& regions,
                                                             std::size_t most) {
  std::vector<std::pair<double, std::uint32_t>> order(regions.count);
  for (std::uint32_t i = 0; i < regions.count; ++i) order[i] = {0, i};
  for (const BrightRun& run : regions.runs) {
    double row = 0;
    for (int x = run.begin; x < run.end; ++x) row += double(luminance(map.at(x, run.row)));
    order[run.region].first -= row * texel_solid_angle(run.row, map.width, map.height);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(most, order.size()));
  std::vector<std::uint32_t> place(regions.count, std::numeric_limits<std::uint32_t>::max());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i].second] = std::uint32_t(i);
  std::vector<std::vector<BrightRun>> brightest(order.size());
  for (const BrightRun& run : regions.runs)
    if (place[run.region] < brightest.size()) brightest[place[run.region]].push_back(run);
  return brightest;
}

}  // namespace coppice::detail

namespace coppice {

/// The peaks of a map, and the texels that they stand for.
struct Peaks {
  std::vector<SgLight> lights;
  std::vector<BrightRun> runs;
};

/// The peaks of a map (SG section 6): regions above a threshold, those of most energy first, each as one to
/// three Gaussians of the same mean direction, spread and energy as its part of the region. A texel counts as
/// the area that it is, so that a sun of one texel gets the texel's width. `mean_luminance`: of the map, over
/// the sphere. Directions are those of the map, not turned.
/// Cost: one pass over the map. Preconditions: the map has texels, the options are in their ranges.
template <Executor E = Serial>
Peaks find_peaks_and_texels(const Image& map, double mean_luminance, const PeakOptions& options,
                            const E& executor = {}) {
  COPPICE_ASSERT(options.threshold > 1 && options.per_peak >= 1 && options.per_peak <= 3);
  Peaks peaks;
  const double threshold = double(options.threshold) * mean_luminance;
  if (options.most == 0 || threshold >= double(std::numeric_limits<float>::max())) return peaks;
  const BrightRegions regions = bright_regions(map, float(threshold), executor);
  if (regions.count == 0) return peaks;
  const detail::TexelFrame frame(map.width, map.height);
  for (const auto& runs : detail::brightest_regions(map, regions, options.most)) {
    const std::size_t left = options.most - peaks.lights.size();
    if (left == 0) break;
    const std::size_t before = peaks.lights.size();
    detail::append_peak(map, runs, frame, std::min(left, std::size_t(options.per_peak)), peaks.lights);
    if (detail::luminance_from(peaks.lights, before) <
        double(options.least_share) * 4 * std::numbers::pi * mean_luminance) {
      peaks.lights.resize(before);  // those that follow have less
      break;
    }
    peaks.runs.insert(peaks.runs.end(), runs.begin(), runs.end());
  }
  return peaks;
}

/// The same without the texels.
template <Executor E = Serial>
std::vector<SgLight> find_peaks(const Image& map, double mean_luminance, const PeakOptions& options,
                                const E& executor = {}) {
  return find_peaks_and_texels(map, mean_luminance, options, executor).lights;
}

}  // namespace coppice
