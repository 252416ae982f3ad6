// An environment map as spherical Gaussians, in real time: peaks, and the rest on a HEALPix grid.
#pragma once

#include <coppice/shared/sg.h>

#include <coppice/sg/environment_grid.hpp>
#include <coppice/sg/fit_level.hpp>
#include <coppice/sg/peaks.hpp>

namespace coppice {

/// How the rest of a map, its peaks taken out, becomes Gaussians.
enum class FitScheme {
  one_level,  ///< 12 nside² Gaussians of one sharpness
  pyramid     ///< the paper's multiscale residuals (SG section 6): nside/2^k, …, nside/2, nside
};

/// The knobs of a fit; docs/sg.md has what each buys.
struct EnvironmentFitOptions {
  FitScheme scheme = FitScheme::one_level;
  /// Of the finest level: 12 nside² Gaussians, 16 nside² - 4 with the pyramid of a power of two. 2 to 16.
  int nside = 8;
  /// What a Gaussian has fallen to half way to its neighbour. 0.4 to 0.75.
  float overlap = 0.6f;
  /// Jacobi passes a level. 1 to 64: more are sharper, and have more negative amplitudes.
  int passes = 8;
  /// Sharpness of the windows that the fit compares means under, over that of the Gaussians. 0.25 to 2.
  float window = 0.5f;
  /// The map is first gathered into 12 grid_nside² pixels. At least 4 nside.
  int grid_nside = 32;
  PeakOptions peaks;
};

/// Gaussians whose sum is the radiance from each direction.
struct EnvironmentFit {
  std::vector<SgLight> lights;  ///< the peaks first
  std::size_t peak_count = 0;

  std::span<const SgLight> peaks() const { return std::span(lights).first(peak_count); }
  std::span<const SgLight> rest() const { return std::span(lights).subspan(peak_count); }
};

/// A direction of a map that is not turned, in the environment that is turned by `rotation`.
inline vec3 turned_direction(const vec3& d, float rotation) {
  const double c = std::cos(double(rotation)), s = std::sin(double(rotation));
  return vec3(glm::dvec3(c * double(d.x) + s * double(d.z), d.y, c * double(d.z) - s * double(d.x)));
}

/// Fits environments of one size. What does not depend on the radiance is made once, in the constructor.
class EnvironmentFitter {
 public:
  /// Preconditions: the options are in their ranges, at least one texel. Cost: docs/sg.md.
  EnvironmentFitter(const EnvironmentFitOptions& options, int width, int height)
      : options_(options), grid_(options.grid_nside, width, height) {
    COPPICE_ASSERT(options.nside >= 1 && options.passes >= 1 && options.window > 0);
    COPPICE_ASSERT(options.overlap > 0 && options.overlap < 1 && options.grid_nside >= options.nside);
    const int coarsest = options.scheme == FitScheme::pyramid ? 1 : options.nside;
    std::vector<int> sides{options.nside};
    while (sides.back() / 2 >= coarsest) sides.push_back(sides.back() / 2);
    for (auto nside = sides.rbegin(); nside != sides.rend(); ++nside) {
      levels_.emplace_back(grid_, *nside, options.overlap, options.window, shapes_);
      for (const vec3& axis : levels_.back().axes()) shapes_.push_back({axis, levels_.back().sharpness()});
    }
  }

  const EnvironmentFitOptions& options() const { return options_; }
  const EnvironmentGrid& grid() const { return grid_; }
  /// Gaussians of the rest.
  std::size_t rest_count() const { return shapes_.size(); }

  /// The levels, coarse to fine, and the Gaussians of all in the order of their amplitudes: for who solves
  /// the equations elsewhere.
  std::span<const detail::FitLevel> levels() const { return levels_; }
  std::span<const SgShape> shapes() const { return shapes_; }

  /// The Gaussians of an environment: first those of its peaks, then the grid's, which stand for what is left
  /// when the peaks' are subtracted. Radiance of the rest, and amplitudes, may be negative. Energy is kept to
  /// 1e-6. A turn of the environment turns the axes and nothing else.
  /// Precondition: the map has the constructor's size.
  template <Executor E = Serial>
  EnvironmentFit fit(const Environment& environment, const E& executor = {}) const {
    return fit_by(environment, executor, [&](const auto& cells, const auto& peaks) {
      std::vector<vec3> amplitudes(shapes_.size(), vec3(0));
      for (const detail::FitLevel& level : levels_)
        level.solve(level.means(grid_, cells, peaks, executor), options_.passes, amplitudes, executor);
      return amplitudes;
    });
  }

  /// The same where solve(cells, peaks) gives the amplitudes of all shapes.
  template <Executor E, class Solve>
  EnvironmentFit fit_by(const Environment& environment, const E& executor, Solve&& solve) const {
    const std::vector<EnvironmentCell> cells = grid_.gather(environment.map, executor);
    glm::dvec3 energy(0);
    for (const EnvironmentCell& cell : cells) energy += glm::dvec3(cell.energy);
    const double mean = glm::dot(energy, glm::dvec3(0.2126, 0.7152, 0.0722)) / (4 * std::numbers::pi);
    EnvironmentFit result;
    result.lights = find_peaks(environment.map, mean, options_.peaks, executor);
    result.peak_count = result.lights.size();
    std::vector<vec3> amplitudes = solve(cells, result.lights);
    keep_energy(energy - sg_energy(result.lights), amplitudes);
    for (std::size_t i = 0; i < shapes_.size(); ++i)
      result.lights.push_back(sg_light(shapes_[i], amplitudes[i]));
    for (SgLight& light : result.lights) light.axis = turned_direction(light.axis, environment.rotation);
    return result;
  }

 private:
  /// Adds to the finest level what is missing, evenly.
  void keep_energy(glm::dvec3 missing, std::span<vec3> amplitudes) const {
    for (std::size_t i = 0; i < shapes_.size(); ++i)
      missing -= double(sg_integral(shapes_[i].sharpness)) * glm::dvec3(amplitudes[i]);
    const detail::FitLevel& finest = levels_.back();
    const double integrals = double(sg_integral(finest.sharpness())) * double(finest.axes().size());
    for (vec3& amplitude : amplitudes.subspan(finest.first())) amplitude += vec3(missing / integrals);
  }

  EnvironmentFitOptions options_;
  EnvironmentGrid grid_;
  std::vector<detail::FitLevel> levels_;  ///< coarse to fine
  std::vector<SgShape> shapes_;           ///< of all levels, in the order of their amplitudes
};

}  // namespace coppice
