// One level of the fit of an environment: Gaussians on a HEALPix grid, and the equations for their
// amplitudes.
#pragma once

#include <coppice/shared/sg.h>

#include <algorithm>
#include <coppice/core/parallel.hpp>
#include <coppice/sg/environment_grid.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// The sharpness at which Gaussians on the centres of a HEALPix grid fall to `overlap` half way to their
/// neighbours: λ = ln v/(cos(θ/2) - 1), θ² = 4π/(12 nside²). Precondition: 0 < overlap < 1.
inline float sg_grid_sharpness(int nside, float overlap) {
  const double s = std::sin(std::sqrt(Healpix(nside).pixel_area()) / 4);  // 1 - cos(θ/2) = 2 sin²(θ/4)
  return float(-std::log(double(overlap)) / (2 * s * s));
}

}  // namespace coppice

namespace coppice::detail {

/// A sparse matrix, row by row.
struct SparseRows {
  std::vector<std::uint32_t> begins{0}, columns;
  std::vector<float> values;

  void append(std::uint32_t column, float value) {
    columns.push_back(column);
    values.push_back(value);
  }
  void end_row() { begins.push_back(std::uint32_t(columns.size())); }
};

/// A level and what it is fitted by. Means under wide windows, not values, are to agree: with windows w_i
/// about the same centres that are Gaussians too, the equations are
///   Σ_k A_ik μ_k = ∫ w_i L / ∫ w_i,   A_ik = ∫ w_i G_k / ∫ w_i.
/// A, and the parts of L that are Gaussians already, have closed forms. The equations ask for what lobes
/// wider than the grid see and leave the rest free, and they know where in a cell its light lies.
class FitLevel {
 public:
  /// `before`: the Gaussians of the levels that are fitted before, in the order of their amplitudes.
  /// `window`: sharpness of the windows over that of the Gaussians.
  /// Cost: 12 nside² · pixels of the grid, once.
  FitLevel(const EnvironmentGrid& grid, int nside, float overlap, float window,
           std::span<const SgShape> before)
      : first_(before.size()),
        sharpness_(sg_grid_sharpness(nside, overlap)),
        window_(window * sharpness_),
        axes_(healpix_centres(nside)) {
    std::vector<SgShape> shapes(before.begin(), before.end());
    for (const vec3& axis : axes_) shapes.push_back({axis, sharpness_});
    double sum = 0;
    for (const vec3& axis : axes_) {
      append_window(grid, axis);
      sum += append_equation(axis, shapes);
    }
    step_ = float(double(axes_.size()) / sum);
  }

  std::span<const vec3> axes() const { return axes_; }
  float sharpness() const { return sharpness_; }
  std::size_t first() const { return first_; }
  /// Sharpness of the windows.
  float window() const { return window_; }
  /// Of a Jacobi pass: 1/c.
  float step() const { return step_; }
  /// A row a Gaussian: weights of the grid's pixels in its window.
  const SparseRows& windows() const { return windows_; }
  /// A row a Gaussian: A, over the Gaussians of the levels before and this.
  const SparseRows& model() const { return model_; }

  /// The right-hand sides: means under the windows of the cells less the peaks.
  template <Executor E>
  std::vector<vec3> means(const EnvironmentGrid& grid, std::span<const EnvironmentCell> cells,
                          std::span<const SgLight> peaks, const E& executor) const {
    std::vector<vec3> result(axes_.size());
    executor(axes_.size(), 32, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        result[i] = vec3(mean_of_cells(i, grid, cells) - mean_of_lights(i, peaks));
    });
    return result;
  }

  /// Jacobi passes, each divided by the mean c of ΣA over the level: without it they diverge where Gaussians
  /// overlap. `amplitudes`: those of all levels; this one's are set.
  template <Executor E>
  void solve(std::span<const vec3> means, int passes, std::span<vec3> amplitudes, const E& executor) const {
    const std::span<vec3> own = amplitudes.subspan(first_, axes_.size());
    std::fill(own.begin(), own.end(), vec3(0));
    std::vector<vec3> left(axes_.size());
    for (int pass = 0; pass < passes; ++pass) {
      executor(axes_.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) left[i] = means[i] - mean_of_model(i, amplitudes);
      });
      for (std::size_t i = 0; i < own.size(); ++i) own[i] += step_ * left[i];
    }
  }

 private:
  /// Windows end where they have fallen to 1e-4, and their weights add up to 1 over the cells' areas.
  void append_window(const EnvironmentGrid& grid, const vec3& axis) {
    const std::span<const vec3> centres = grid.centres();
    const std::size_t begin = windows_.values.size();
    const float lowest = 1 + std::log(1e-4f) / window_;
    double sum = 0;
    for (std::uint32_t j = 0; j < centres.size(); ++j) {
      if (dot(axis, centres[j]) < lowest) continue;
      const float value = std::exp(window_ * (dot(axis, centres[j]) - 1));
      windows_.append(j, value);
      sum += double(value) * double(grid.areas()[j]);
    }
    for (std::size_t i = begin; i < windows_.values.size(); ++i)
      windows_.values[i] = float(double(windows_.values[i]) / sum);
    windows_.end_row();
  }

  /// One row of A; the sum over this level's Gaussians.
  double append_equation(const vec3& axis, std::span<const SgShape> shapes) {
    const SgShape window{axis, window_};
    const float scale = sg_normalisation(window_);
    double sum = 0;
    for (std::uint32_t k = 0; k < shapes.size(); ++k) {
      const float value = scale * sg_inner_product(window, shapes[k]);
      if (value < 1e-7f) continue;
      model_.append(k, value);
      if (k >= first_) sum += double(value);
    }
    model_.end_row();
    return sum;
  }

  /// Σ w E, w taken to where each cell's light lies: e^t to second order, |t| < ½.
  glm::dvec3 mean_of_cells(std::size_t row, const EnvironmentGrid& grid,
                           std::span<const EnvironmentCell> cells) const {
    const vec3 slope = window_ * axes_[row];
    glm::dvec3 sum(0);  // beside a sun of 1e5 floats lose what is left
    for (std::uint32_t e = windows_.begins[row]; e < windows_.begins[row + 1]; ++e) {
      const std::uint32_t j = windows_.columns[e];
      const float t = dot(slope, cells[j].centre - grid.centres()[j]);
      sum += double(windows_.values[e] * (1 + t * (1 + 0.5f * t))) * glm::dvec3(cells[j].energy);
    }
    return sum;
  }

  glm::dvec3 mean_of_lights(std::size_t row, std::span<const SgLight> lights) const {
    const float scale = sg_normalisation(window_);
    glm::dvec3 sum(0);
    for (const SgLight& light : lights)
      sum += double(scale * sg_inner_product({axes_[row], window_}, {light.axis, light.sharpness})) *
             glm::dvec3(light.amplitude);
    return sum;
  }

  vec3 mean_of_model(std::size_t row, std::span<const vec3> amplitudes) const {
    vec3 sum(0);
    for (std::uint32_t e = model_.begins[row]; e < model_.begins[row + 1]; ++e)
      sum += model_.values[e] * amplitudes[model_.columns[e]];
    return sum;
  }

  std::size_t first_;  ///< Gaussians before this level's
  float sharpness_, window_;
  float step_ = 1;  ///< 1/c
  std::vector<vec3> axes_;
  SparseRows windows_;  ///< over cells
  SparseRows model_;    ///< A, over the Gaussians of the levels before and this
};

}  // namespace coppice::detail
