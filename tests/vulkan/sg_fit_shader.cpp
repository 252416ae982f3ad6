// Fits of environments on the device against those of the CPU, and against the equations in double.
#include <coppice/vulkan/sg_shader.hpp>
//
#include <doctest/doctest.h>

#include <cmath>

#include "random_input.hpp"
#include "shaded.hpp"
#include "support/executors.hpp"
#include "support/generators.hpp"
#include "support/scenes.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

std::vector<vec3> amplitudes(std::span<const SgLight> lights) {
  std::vector<vec3> all;
  for (const SgLight& light : lights) all.push_back(light.amplitude);
  return all;
}

/// ∫ of a product of Gaussians.
double inner_product(const glm::dvec3& a, double sharpness_a, const glm::dvec3& b, double sharpness_b) {
  const glm::dvec3 p = glm::normalize(a), q = glm::normalize(b);
  const double length = glm::length(sharpness_a * p + sharpness_b * q), sum = sharpness_a + sharpness_b;
  const double scale = std::exp(-sharpness_a * sharpness_b * glm::dot(p - q, p - q) / (length + sum));
  return scale * 4 * std::numbers::pi * (length > 1e-9 ? -std::expm1(-2 * length) / (2 * length) : 1);
}

/// The amplitudes of EnvironmentFitter's equations (FitLevel), in double.
class ExactFit {
 public:
  ExactFit(const EnvironmentFitter& fitter, const Environment& environment, std::span<const SgLight> peaks)
      : fitter_(fitter), cells_(fitter.grid().gather(environment.map)), peaks_(peaks) {
    const EnvironmentFitOptions& o = fitter.options();
    std::vector<int> sides{o.nside};
    while (o.scheme == FitScheme::pyramid && sides.back() > 1) sides.push_back(sides.back() / 2);
    for (auto nside = sides.rbegin(); nside != sides.rend(); ++nside) solve(*nside);
    keep_energy();
  }

  std::vector<vec3> amplitudes() const { return {amplitudes_.begin(), amplitudes_.end()}; }

 private:
  /// The mean of the cells less the peaks under the window about an axis that is not turned.
  glm::dvec3 mean_under(const glm::dvec3& axis, double window) const {
    const std::span<const vec3> centres = fitter_.grid().centres();
    glm::dvec3 sum(0);
    double weights = 0;
    for (std::size_t j = 0; j < centres.size(); ++j) {
      const double away = 1 - glm::dot(axis, glm::dvec3(centres[j]));
      if (window * away > -std::log(1e-4)) continue;
      const double weight = std::exp(-window * away);
      const double t = window * glm::dot(axis, glm::dvec3(cells_[j].centre) - glm::dvec3(centres[j]));
      sum += weight * (1 + t + t * t / 2) * glm::dvec3(cells_[j].energy);
      weights += weight * double(fitter_.grid().areas()[j]);
    }
    sum /= weights;
    const double scale = 1 / inner_product(axis, window, axis, 0);
    for (const SgLight& peak : peaks_)
      sum -=
          scale * inner_product(axis, window, peak.axis, double(peak.sharpness)) * glm::dvec3(peak.amplitude);
    return sum;
  }

  void solve(int nside) {
    const EnvironmentFitOptions& o = fitter_.options();
    const double sharpness = double(sg_grid_sharpness(nside, o.overlap)),
                 window = double(o.window) * sharpness;
    const std::vector<vec3> axes = healpix_centres(nside);
    first_ = shapes_.size();
    for (const vec3& axis : axes) shapes_.push_back({axis, float(sharpness)}), amplitudes_.emplace_back(0);
    std::vector<std::vector<double>> rows;
    std::vector<glm::dvec3> means;
    double own = 0;
    for (const vec3& axis : axes) {
      means.push_back(mean_under(axis, window));
      rows.emplace_back();
      for (const SgShape& s : shapes_) {
        const double value =
            inner_product(axis, window, s.axis, double(s.sharpness)) / inner_product(axis, window, axis, 0);
        rows.back().push_back(value < 1e-7 ? 0 : value);
      }
      for (std::size_t k = first_; k < shapes_.size(); ++k) own += rows.back()[k] / double(axes.size());
    }
    for (int pass = 0; pass < o.passes; ++pass) {
      const std::vector<glm::dvec3> before = amplitudes_;
      for (std::size_t i = 0; i < axes.size(); ++i) {
        glm::dvec3 left = means[i];
        for (std::size_t k = 0; k < shapes_.size(); ++k) left -= rows[i][k] * before[k];
        amplitudes_[first_ + i] += left / own;
      }
    }
  }

  void keep_energy() {
    glm::dvec3 missing = -sg_energy(peaks_);
    for (const EnvironmentCell& cell : cells_) missing += glm::dvec3(cell.energy);
    for (std::size_t i = 0; i < shapes_.size(); ++i)
      missing -= double(sg_integral(shapes_[i].sharpness)) * amplitudes_[i];
    const double integral = double(sg_integral(shapes_.back().sharpness));
    for (std::size_t i = first_; i < shapes_.size(); ++i)
      amplitudes_[i] += missing / (integral * double(shapes_.size() - first_));
  }

  const EnvironmentFitter& fitter_;
  std::vector<EnvironmentCell> cells_;
  std::span<const SgLight> peaks_;
  std::size_t first_ = 0;  ///< Gaussians before the last level
  std::vector<SgShape> shapes_;
  std::vector<glm::dvec3> amplitudes_;
};

bool same_shapes(std::span<const SgLight> a, std::span<const SgLight> b) {
  return std::ranges::equal(a, b, [](const SgLight& x, const SgLight& y) {
    return x.axis == y.axis && x.sharpness == y.sharpness;
  });
}

/// The same peaks and shapes. Returns the relative RMS difference of the rest's amplitudes.
double check_same_lights(const EnvironmentFit& device, const EnvironmentFit& cpu) {
  REQUIRE(device.lights.size() == cpu.lights.size());
  CHECK(device.peak_count == cpu.peak_count);
  CHECK(same_shapes(device.lights, cpu.lights));
  CHECK(amplitudes(device.peaks()) == amplitudes(cpu.peaks()));
  return relative_rms(amplitudes(device.rest()), amplitudes(cpu.rest()));
}

Environment soft_sky(int width = 96, int height = 48) {
  return support::sky(normalize(vec3(1, 1.2f, 0.6f)), width, height);
}

std::vector<EnvironmentFitOptions> all_options() {
  std::vector<EnvironmentFitOptions> all;
  for (const FitScheme scheme : {FitScheme::one_level, FitScheme::pyramid}) {
    EnvironmentFitOptions usual, one, odd, many;
    one.nside = 1, one.passes = 1;
    odd.nside = 3, odd.passes = 7, odd.window = 2;
    many.nside = 4, many.overlap = 0.75f, many.passes = 64, many.grid_nside = 16;
    for (EnvironmentFitOptions options : {usual, one, odd, many}) {
      options.scheme = scheme;
      all.push_back(options);
    }
  }
  return all;
}

EnvironmentFitOptions coarse(FitScheme scheme = FitScheme::one_level) {
  EnvironmentFitOptions options;
  options.scheme = scheme, options.nside = 4, options.grid_nside = 16;
  return options;
}

}  // namespace

TEST_CASE("environments fitted on the device are those of the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(1);
  double worst = 0;
  for (const EnvironmentFitOptions& options : all_options()) {
    CAPTURE(options.nside);
    const EnvironmentFitter fitter(options, 96, 48);
    SgFitShader shader(device, fitter);
    for (const Environment& environment :
         {soft_sky(), Environment{test_support::random_map(random, 96, 48), 0.7f}}) {
      const double difference = check_same_lights(shader.fit(environment), fitter.fit(environment));
      CHECK(difference < 1e-3);
      worst = std::max(worst, difference);
    }
  }
  MESSAGE("relative RMS difference of amplitudes: " << worst);
}

// The sun is a peak; what is left of its cell is the difference of two numbers that are 1e3 times as large,
// from which the CPU's sums in one register cannot tell the rest as well as the device's in many.
TEST_CASE("what a sun of 1e5 leaves of a sky is fitted on the device as in double") {
  if (!has_device()) return;
  VulkanDevice device;
  Environment environment = soft_sky();
  environment.map.at(32, 12) = vec3(1e5f, 9e4f, 8e4f);
  double worst = 0, of_cpu = 0;
  for (const EnvironmentFitOptions& options : all_options()) {
    CAPTURE(options.nside);
    const EnvironmentFitter fitter(options, 96, 48);
    SgFitShader shader(device, fitter);
    const EnvironmentFit fit = shader.fit(environment);
    CHECK(fit.peak_count == 1);
    const ExactFit exact(fitter, environment, fit.peaks());
    const double difference = relative_rms(amplitudes(fit.rest()), exact.amplitudes());
    CHECK(difference < 1e-3);
    worst = std::max(worst, difference);
    of_cpu = std::max(of_cpu, check_same_lights(fit, fitter.fit(environment)));
  }
  CHECK(of_cpu < 1e-3);
  MESSAGE("relative RMS difference of amplitudes from double: " << worst << ", from the CPU: " << of_cpu);
}

TEST_CASE("a fit on the device keeps the energy of a map") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(2);
  const EnvironmentFitter fitter({}, 80, 40);
  SgFitShader shader(device, fitter);
  for (const Environment& environment :
       {soft_sky(80, 40), Environment{test_support::random_map(random, 80, 40), 0}}) {
    glm::dvec3 energy(0);
    for (const EnvironmentCell& cell : fitter.grid().gather(environment.map))
      energy += glm::dvec3(cell.energy);
    CHECK(glm::length(sg_energy(shader.fit(environment).lights) - energy) < 1e-6 * glm::length(energy));
  }
}

TEST_CASE("black maps are fitted on the device by nothing, maps of one texel by what is even") {
  if (!has_device()) return;
  VulkanDevice device;
  const EnvironmentFitter fitter(coarse(), 32, 16), of_one(coarse(), 1, 1);
  SgFitShader shader(device, fitter), shader_of_one(device, of_one);
  CHECK(shader.fit(soft_sky(32, 16)).lights.size() >= fitter.rest_count());
  const EnvironmentFit black = shader.fit({Image(32, 16), 0});
  CHECK(black.peak_count == 0);
  CHECK(amplitudes(black.lights) == std::vector<vec3>(fitter.rest_count(), vec3(0)));
  const Environment even{Image(1, 1, vec3(3, 2, 1)), 0};
  CHECK(check_same_lights(shader_of_one.fit(even), of_one.fit(even)) < 1e-4);
}

TEST_CASE("a shader fits the same bits for any executor, after other maps, and when it has moved") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(3);
  const EnvironmentFitter fitter(coarse(FitScheme::pyramid), 48, 24);
  SgFitShader shader(device, fitter);
  const auto before = amplitudes(shader.fit(soft_sky(48, 24)).lights);
  const EnvironmentFit other = shader.fit({test_support::random_map(random, 48, 24), 0});
  CHECK(other.peak_count > 10);
  CHECK(amplitudes(shader.fit(soft_sky(48, 24), support::TwoThreads{}).lights) == before);
  SgFitShader moved(std::move(shader));
  CHECK(amplitudes(moved.fit(soft_sky(48, 24)).lights) == before);
  if (moved.milliseconds()) CHECK(*moved.milliseconds() > 0);
}

TEST_CASE("the validation layer has nothing to say of fits") {
  if (!has_device({.validation = true})) return;
  VulkanDevice device({.validation = true});
  const EnvironmentFitter fitter(coarse(FitScheme::pyramid), 32, 16);
  SgFitShader shader(device, fitter);
  CHECK(check_same_lights(shader.fit(soft_sky(32, 16)), fitter.fit(soft_sky(32, 16))) < 1e-3);
  for (const std::string& message : device.validation_messages()) FAIL_CHECK(message);
}
