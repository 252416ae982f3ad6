// How the tables of fitted Gaussians are looked up.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace coppice::detail {

inline constexpr int gaussian_rows = 13, gaussian_columns = 17;
inline constexpr float gaussian_least_root = 0.3f;

/// Rows by -2 log₂ alpha, columns by the fourth root of the viewer's cosine from gaussian_least_root to 1. In
/// each the fourth root of the albedo · 10⁴, and for each lobe what GaussianFit has, · 10³.
template <int Lobes>
using GaussianTable = short[gaussian_rows][gaussian_columns][1 + 4 * std::size_t(Lobes)];

/// One Gaussian of a fit, for width alpha. Its axis lies in the plane of incidence.
struct GaussianFit {
  float tilt;           ///< angle of the axis from the mirror direction towards the normal, over alpha
  float log_sharpness;  ///< ln(2 alpha² λ)
  float log_ratio;      ///< ln(1 + stripe/λ), >= 0
  float share;          ///< of the albedo
};

template <int Lobes>
struct GaussianEntry {
  float albedo;  ///< of Blinn-Phong, still to be multiplied by shrink²
  float shrink;  ///< the viewer's cosine over that of the column: 1 from the least alpha of the table on
  std::array<GaussianFit, std::size_t(Lobes)> lobes;
};

/// Where x lies between the whole numbers 0 … last.
struct GridPlace {
  int index;
  float share;  ///< of index + 1
};
inline GridPlace grid_place(float x, int last) {
  const float inside = std::clamp(x, 0.0f, float(last));
  const int index = std::min(int(inside), last - 1);
  return {index, inside - float(index)};
}

/// The entry between rows and columns, linear in log(alpha) and in the fourth root of the cosine. Below the
/// least alpha a lobe at cosine c is that of the last row at the cosine whose cotangent is larger as alpha is
/// smaller, shrunk with alpha, and narrower across as both are nearer to the horizon.
template <int Lobes>
GaussianEntry<Lobes> look_up(const GaussianTable<Lobes>& table, float alpha, float cosine) {
  constexpr float least = 1.0f / 64;
  const float k = std::max(least / alpha, 1.0f);
  const float column_cosine = cosine * k / std::sqrt(1 + cosine * cosine * (k * k - 1));
  const auto [row, down] = grid_place(-2 * std::log2(alpha), gaussian_rows - 1);
  const auto [column, right] = grid_place((std::sqrt(std::sqrt(column_cosine)) - gaussian_least_root) *
                                              (float(gaussian_columns - 1) / (1 - gaussian_least_root)),
                                          gaussian_columns - 1);
  const auto at = [&, r = row, d = down, c = column, s = right](int i) {
    const float left = (1 - d) * float(table[r][c][i]) + d * float(table[r + 1][c][i]);
    return (1 - s) * left + s * ((1 - d) * float(table[r][c + 1][i]) + d * float(table[r + 1][c + 1][i]));
  };
  GaussianEntry<Lobes> entry;
  const float root = 1e-4f * at(0);
  entry.albedo = root * root * (root * root);
  entry.shrink = cosine / column_cosine;
  const float narrower = -2 * std::log(entry.shrink);
  for (int i = 0; i < Lobes; ++i)
    entry.lobes[std::size_t(i)] = {1e-3f * at(4 * i + 1), 1e-3f * at(4 * i + 2),
                                   1e-3f * at(4 * i + 3) + narrower, 1e-3f * at(4 * i + 4)};
  return entry;
}

/// max(0, cosine)ⁿ as Gaussians of λ and phong_ratio · λ about its axis.
struct PhongFit {
  float log_sharpness;  ///< ln(λ/n)
  float share;          ///< of the energy that is the second's, times n; negative
};
inline constexpr float phong_ratio = 1.5f;

/// The fit at an exponent n >= 1, linear in 1/n between the entries at 1/n = (i/8)².
inline PhongFit phong_fit(const PhongFit (&table)[9], float exponent) {
  const float inverse = std::min(1 / exponent, 1.0f);
  const int i = std::min(int(8 * std::sqrt(inverse)), 7);
  const float share = (64 * inverse - float(i * i)) / float(2 * i + 1);
  const PhongFit &a = table[i], &b = table[i + 1];
  return {a.log_sharpness + share * (b.log_sharpness - a.log_sharpness),
          a.share + share * (b.share - a.share)};
}

}  // namespace coppice::detail
