// Fits Gaussians to GGX, Blinn-Phong, Ward and Phong; prints the rows of include/coppice/sg/*_table.hpp.
//
//     c++ -std=c++20 -O3 -ffast-math -march=native -I include scripts/fit_gaussians.cpp -o fit_gaussians
//     ./fit_gaussians ggx|blinn_phong|ward|phong
//
// Rows: alpha = 2^(-i/2), columns: fourth root of the viewer's cosine = 0.3 + 0.7 j/16; of Blinn-Phong alpha²
// = 2/(exponent + 2). What is fitted is the lobe times the cosine over the directions of the light, by a sum
// of
//     share · albedo · G / ∫G,   G = exp(-λ |d - p|²/2 - ν (d·y)²/2) above the horizon, 0 below,
// y across the plane of incidence, p in it. The fit minimises E(∞)² + E(50)² + E(5)², E(λ) the relative L2
// error after convolution with a Gaussian of that λ (∞: as it is), and a little of its distance from the mean
// of its neighbours, so that the rows and columns can be interpolated.
#include <coppice/shared/brdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <vector>

namespace {

using coppice::uint;
using coppice::vec3;
using glm::dvec3;
using std::numbers::pi;

constexpr int rows = 13, columns = 17;
constexpr double phong_ratio = 1.5;

double alpha_of(int row) { return std::exp2(-0.5 * row); }
double cosine_of(int column) {
  const double root = 0.3 + 0.7 * column / (columns - 1);
  return root * root * root * root;
}

/// What is fitted, a lobe after the other: (elevation of the axis - that of the mirror direction)/alpha,
/// ln(2 alpha² λ), ln(1 + ν/λ), ln(share / share of the last lobe).
using Parameters = std::vector<double>;

struct Node {
  dvec3 direction;
  double weight;  ///< solid angle
};

/// Directions of the light over half of the upper half of the sphere (all is even in y), as half vectors of a
/// lobe of this width reflect them. The rings are broken, so that none runs along the horizon.
std::vector<Node> nodes_of(double cosine, double width, int rings, int turns) {
  const dvec3 viewer(std::sqrt(1 - cosine * cosine), 0, cosine);
  const double scale = 0.5 * width, most = std::asinh(1e3 / scale);
  std::vector<Node> nodes;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < turns; ++j) {
      const double u = most * (i + std::fmod(0.618034 * (j + 1), 1.0)) / rings, turn = pi * (j + 0.5) / turns;
      const double tangent = scale * std::sinh(u), z = 1 / std::sqrt(1 + tangent * tangent);
      const dvec3 half(z * tangent * std::cos(turn), z * tangent * std::sin(turn), z);
      const double part = dot(half, viewer);
      const dvec3 light = 2 * part * half - viewer;
      if (part <= 0 || light.z <= 0) continue;
      const double area = tangent * z * z * z * scale * std::cosh(u) * most / rings * 2 * pi / turns;
      nodes.push_back({light, 4 * part * area});
    }
  return nodes;
}

/// Directions over half the sphere, more of them within `width` of the mirror direction.
std::vector<Node> nodes_about_mirror(double cosine, double width, int rings, int turns) {
  const double sine = std::sqrt(1 - cosine * cosine);
  const dvec3 mirror(-sine, 0, cosine), up(cosine, 0, sine);
  const double most = std::asinh(pi / width);
  std::vector<Node> nodes;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < turns; ++j) {
      const double u = most * (i + 0.5) / rings, angle = width * std::sinh(u), turn = pi * (j + 0.5) / turns;
      const dvec3 across = up * std::cos(turn) + dvec3(0, 1, 0) * std::sin(turn);
      const double weight = std::sin(angle) * width * std::cosh(u) * most / rings * 2 * pi / turns;
      nodes.push_back({mirror * std::cos(angle) + across * std::sin(angle), weight});
    }
  return nodes;
}

/// The solution x of A x = b, A symmetric and positive definite; row by row.
std::vector<double> solve(std::vector<double> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = i + 1; k < n; ++k) {
      const double factor = a[k * n + i] / a[i * n + i];
      for (std::size_t j = i; j < n; ++j) a[k * n + j] -= factor * a[i * n + j];
      b[k] -= factor * b[i];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t j = i + 1; j < n; ++j) b[i] -= a[i * n + j] * b[j];
    b[i] /= a[i * n + i];
  }
  return b;
}

/// The least squares Σ residual² by Levenberg and Marquardt, from `start`.
template <class F>
Parameters minimise(Parameters start, F residuals, int rounds) {
  const auto sum = [](const std::vector<double>& r) {
    double s = 0;
    for (const double x : r) s += x * x;
    return s;
  };
  std::vector<double> r = residuals(start);
  const std::size_t n = start.size();
  double damping = 1e-2, least = sum(r);
  for (int round = 0; round < rounds && damping < 1e8; ++round) {
    std::vector<std::vector<double>> slope(n);
    for (std::size_t i = 0; i < n; ++i) {
      Parameters moved = start;
      moved[i] += 1e-4;
      slope[i] = residuals(moved);
      for (std::size_t k = 0; k < r.size(); ++k) slope[i][k] = (slope[i][k] - r[k]) / 1e-4;
    }
    std::vector<double> a(n * n), b(n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < r.size(); ++k) b[i] -= slope[i][k] * r[k];
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t k = 0; k < r.size(); ++k) a[i * n + j] += slope[i][k] * slope[j][k];
    }
    for (bool better = false; !better && damping < 1e8;) {
      std::vector<double> damped = a;
      for (std::size_t i = 0; i < n; ++i) damped[i * n + i] += damping * (a[i * n + i] + 1e-6);
      const std::vector<double> step = solve(damped, b);
      Parameters moved = start;
      for (std::size_t i = 0; i < n; ++i) moved[i] += std::clamp(step[i], -0.7, 0.7);
      std::vector<double> next = residuals(moved);
      better = sum(next) < least;
      damping *= better ? 0.2 : 6;
      if (!better) continue;
      const double gain = least - sum(next);
      start = moved, r = std::move(next), least -= gain;
      if (gain < 1e-7 * least) return start;
    }
  }
  return start;
}

/// One width and viewer: where the errors are measured, and what the lobe is there.
class Slice {
 public:
  Slice(uint kind, double width, double cosine)
      : width_(width), elevation_(std::asin(cosine)), nodes_(nodes_of(cosine, width, 56, 24)) {
    const auto far = nodes_about_mirror(cosine, std::max(width, 0.15), 20, 12);
    for (const double sharpness : {50.0, 5.0}) add_blur(far, sharpness);
    const vec3 viewer(float(std::sqrt(1 - cosine * cosine)), 0, float(cosine));
    const float parameter = float(kind == coppice::BRDF_BLINN_PHONG ? 2 / (width * width) - 2 : width);
    for (const Node& n : nodes_) {
      const auto terms = coppice::brdf_terms<double>(kind, parameter, parameter, n.direction.x, n.direction.y,
                                                     n.direction.z, viewer);
      values_.push_back(terms.specular + terms.fresnel);
      albedo_ += values_.back() * n.weight;
    }
    for (double& v : values_) v /= albedo_;
    scale_ = norms(values_);
  }

  /// The sum of Gaussians of energy 1.
  std::vector<double> model(const Parameters& p) const {
    std::vector<double> sum(nodes_.size()), one(nodes_.size());
    double shares = 0;
    for (std::size_t k = 0; k < p.size(); k += 4) shares += std::exp(p[k + 3]);
    for (std::size_t k = 0; k < p.size(); k += 4) {
      const double elevation = std::max(0.0, elevation_ + width_ * p[k]);
      const double sharpness = std::exp(p[k + 1]) / (2 * width_ * width_);
      const double stripe = sharpness * std::expm1(std::max(0.0, p[k + 2]));
      const dvec3 axis(-std::cos(elevation), 0, std::sin(elevation));
      double energy = 1e-30;
      for (std::size_t i = 0; i < nodes_.size(); ++i) {
        const dvec3 d = nodes_[i].direction, apart = d - axis;
        one[i] = std::exp(-0.5 * (sharpness * dot(apart, apart) + stripe * d.y * d.y));
        energy += one[i] * nodes_[i].weight;
      }
      const double factor = std::exp(p[k + 3]) / shares / energy;
      for (std::size_t i = 0; i < nodes_.size(); ++i) sum[i] += factor * one[i];
    }
    return sum;
  }

  /// Relative errors, their squares sum up to E(∞)² + E(50)² + E(5)².
  std::vector<double> residuals(const Parameters& p) const {
    std::vector<double> apart = model(p);
    for (std::size_t i = 0; i < apart.size(); ++i) apart[i] -= values_[i];
    return weighted(apart, scale_);
  }

  std::array<double, 3> errors(const Parameters& p) const {
    std::vector<double> apart = model(p);
    for (std::size_t i = 0; i < apart.size(); ++i) apart[i] -= values_[i];
    const auto n = norms(apart);
    return {n[0] / scale_[0], n[1] / scale_[1], n[2] / scale_[2]};
  }

 private:
  void add_blur(const std::vector<Node>& far, double sharpness) {
    std::vector<float> matrix;
    for (const Node& t : far)
      for (const Node& n : nodes_) {
        const dvec3 a = t.direction - n.direction;
        const double mirrored = dot(a, a) + 4 * t.direction.y * n.direction.y;
        matrix.push_back(
            float(0.5 * (std::exp(-0.5 * sharpness * dot(a, a)) + std::exp(-0.5 * sharpness * mirrored)) *
                  std::sqrt(t.weight) * n.weight));
      }
    blurs_.push_back(std::move(matrix));
  }

  /// The function as it is and blurred, times the square roots of the weights.
  std::vector<double> weighted(const std::vector<double>& f, const std::array<double, 3>& scale) const {
    std::vector<double> all;
    std::vector<float> single(f.begin(), f.end());
    for (std::size_t i = 0; i < f.size(); ++i) all.push_back(f[i] * std::sqrt(nodes_[i].weight) / scale[0]);
    for (std::size_t b = 0; b < 2; ++b)
      for (std::size_t row = 0; row < blurs_[b].size(); row += f.size()) {
        float sum = 0;
        for (std::size_t i = 0; i < f.size(); ++i) sum += blurs_[b][row + i] * single[i];
        all.push_back(double(sum) / scale[b + 1]);
      }
    return all;
  }
  std::array<double, 3> norms(const std::vector<double>& f) const {
    const std::vector<double> all = weighted(f, {1, 1, 1});
    std::array<double, 3> sums{};
    const std::size_t far = blurs_[0].size() / f.size();
    for (std::size_t i = 0; i < all.size(); ++i)
      sums[i < f.size() ? 0 : i < f.size() + far ? 1 : 2] += all[i] * all[i];
    for (double& s : sums) s = std::sqrt(s);
    return sums;
  }

  double width_, elevation_, albedo_ = 0;
  std::vector<Node> nodes_;
  std::vector<double> values_;
  std::vector<std::vector<float>> blurs_;
  std::array<double, 3> scale_{};
};

class Table {
 public:
  Table(uint kind, int lobes) : kind_(kind), entries_(rows * columns) {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        slices_.emplace_back(kind, alpha_of(row), cosine_of(column));
    Parameters start = {0, 0.8, 0, 1, 0, -0.2, 0, 1, 0, -1.5, 0, 0};
    if (lobes == 2) start = {0, 0.2, 0, 1, 0, -0.2, 0, 0};
    constexpr int first = 8;
    at(first, columns - 1) = fit(first, columns - 1, start, start, 0);
    for (int column = columns - 2; column >= 0; --column) follow(first, column, first, column + 1);
    for (int row = first + 1; row < rows; ++row)
      for (int column = columns - 1; column >= 0; --column) follow(row, column, row - 1, column);
    for (int row = first - 1; row >= 0; --row)
      for (int column = columns - 1; column >= 0; --column) follow(row, column, row + 1, column);
  }

  /// Fits each entry again, nearer to what its neighbours are.
  void smooth(double pull) {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        at(row, column) = fit(row, column, at(row, column), mean_of_neighbours(row, column), pull);
  }

  void print() const {
    for (int row = 0; row < rows; ++row) {
      std::printf("{");
      for (int column = 0; column < columns; ++column) print_entry(row, column);
      std::printf("},\n");
    }
  }

 private:
  Parameters& at(int row, int column) { return entries_[std::size_t(row * columns + column)]; }
  const Slice& slice(int row, int column) const { return slices_[std::size_t(row * columns + column)]; }

  void follow(int row, int column, int from_row, int from_column) {
    at(row, column) = fit(row, column, at(from_row, from_column), at(from_row, from_column), 3e-3);
  }

  Parameters fit(int row, int column, const Parameters& start, const Parameters& middle, double pull) const {
    const Slice& s = slice(row, column);
    const auto residuals = [&](const Parameters& p) {
      std::vector<double> r = s.residuals(p);
      for (std::size_t i = 0; i < p.size(); ++i) r.push_back(pull * (p[i] - middle[i]));
      const bool round = column + 1 == columns;  // seen along the normal, a lobe has no plane
      for (std::size_t i = 0; i < p.size(); ++i) r.push_back((round && i % 2 == 0 ? 1 : 1e-4) * p[i]);
      return r;
    };
    Parameters p = minimise(start, residuals, 30);
    const double elevation = std::asin(cosine_of(column)), width = alpha_of(row);
    for (std::size_t k = 0; k < p.size(); k += 4) {
      p[k] = std::max(p[k], -elevation / width), p[k + 2] = std::max(p[k + 2], 0.0);
      p[k + 3] = p[k + 3] - p[p.size() - 1];
    }
    return p;
  }

  Parameters mean_of_neighbours(int row, int column) const {
    Parameters sum(entries_[0].size());
    int count = 0;
    const auto add = [&](int r, int c) {
      if (r < 0 || r >= rows || c < 0 || c >= columns) return;
      const Parameters& p = entries_[std::size_t(r * columns + c)];
      for (std::size_t i = 0; i < p.size(); ++i) sum[i] += p[i];
      ++count;
    };
    const bool inner_row = row > 0 && row + 1 < rows, inner_column = column > 0 && column + 1 < columns;
    if (inner_row || !inner_column) add(row - 1, column), add(row + 1, column);
    if (inner_column || !inner_row) add(row, column - 1), add(row, column + 1);
    for (double& x : sum) x /= count;
    return sum;
  }

  void print_entry(int row, int column) const;

  uint kind_;
  std::vector<Slice> slices_;
  std::vector<Parameters> entries_;
};

/// ∫ of the lobe times the cosine over directions of the light.
double albedo_of(uint kind, double width, double cosine) {
  const vec3 viewer(float(std::sqrt(1 - cosine * cosine)), 0, float(cosine));
  const float parameter = float(kind == coppice::BRDF_BLINN_PHONG ? 2 / (width * width) - 2 : width);
  double sum = 0;
  for (const Node& n : nodes_of(cosine, width, 400, 400)) {
    const auto terms = coppice::brdf_terms<double>(kind, parameter, parameter, n.direction.x, n.direction.y,
                                                   n.direction.z, viewer);
    sum += (terms.specular + terms.fresnel) * n.weight;
  }
  return sum;
}

void Table::print_entry(int row, int column) const {
  const Parameters& p = entries_[std::size_t(row * columns + column)];
  const double albedo = albedo_of(kind_, alpha_of(row), cosine_of(column));
  std::printf("{%.0f", 1e4 * std::sqrt(std::sqrt(albedo)));
  double shares = 0;
  for (std::size_t k = 0; k < p.size(); k += 4) shares += std::exp(p[k + 3]);
  for (std::size_t k = 0; k < p.size(); k += 4)
    std::printf(", %.0f, %.0f, %.0f, %.0f", 1e3 * p[k], 1e3 * p[k + 1], 1e3 * p[k + 2],
                1e3 * std::exp(p[k + 3]) / shares);
  std::printf("},\n");
  const auto e = slice(row, column).errors(p);
  std::fprintf(stderr, "%.3f %.3f: %4.1f %4.1f %4.1f%%\n", alpha_of(row), cosine_of(column), 100 * e[0],
               100 * e[1], 100 * e[2]);
}

/// max(0, cosine)ⁿ against share 1 Gaussian of λ and share 2 of λ · phong_ratio about its axis, both of
/// energy 1, over the sphere: ln(λ/n), share 2 · n.
std::vector<double> phong_residuals(double n, const Parameters& p) {
  constexpr int steps = 400;
  const double sharpness = n * std::exp(p[0]), share = p[1] / n, width = 1 / std::sqrt(n);
  const double most = std::asinh(pi / width);
  const auto gaussian = [](double s, double cosine) {
    return s / (2 * pi * -std::expm1(-2 * s)) * std::exp(s * (cosine - 1));
  };
  std::vector<double> all;
  for (int i = 0; i < steps; ++i) {
    const double u = most * (i + 0.5) / steps, angle = width * std::sinh(u), cosine = std::cos(angle);
    const double weight = std::sin(angle) * width * std::cosh(u) * most / steps * 2 * pi;
    const double power = cosine > 0 ? (n + 1) / (2 * pi) * std::pow(cosine, n) : 0;
    const double sum =
        (1 - share) * gaussian(sharpness, cosine) + share * gaussian(phong_ratio * sharpness, cosine);
    const double norm = (n + 1) / (2 * pi) * std::sqrt(2 * pi / (2 * n + 1));
    all.push_back((power - sum) / norm * std::sqrt(weight));
  }
  return all;
}

/// Entries at 1/exponent = (i/8)², i = 0 … 8; the first is fitted at exponent 1000.
void print_phong() {
  Parameters p = {0, 0};
  for (int i = 0; i <= 8; ++i) {
    const double root = i / 8.0, n = i == 0 ? 1000 : 1 / (root * root);
    p = minimise(
        p, [&](const Parameters& x) { return phong_residuals(n, x); }, 60);
    double error = 0;
    for (const double r : phong_residuals(n, p)) error += r * r;
    std::printf("{%.4gf, %.4gf},\n", p[0], p[1]);
    std::fprintf(stderr, "exponent %g: %.3f%%\n", n, 100 * std::sqrt(error));
  }
}

}  // namespace

int main(int count, char** arguments) {
  const char* name = count > 1 ? arguments[1] : "";
  uint kind = coppice::BRDF_LAMBERT;
  if (!std::strcmp(name, "ggx")) kind = coppice::BRDF_GGX;
  if (!std::strcmp(name, "blinn_phong")) kind = coppice::BRDF_BLINN_PHONG;
  if (!std::strcmp(name, "ward")) kind = coppice::BRDF_WARD;
  if (kind == coppice::BRDF_LAMBERT) return print_phong(), 0;
  Table table(kind, kind == coppice::BRDF_GGX ? 3 : 2);
  for (const double pull : {5e-2, 5e-2, 5e-2, 2e-2, 2e-2, 2e-2}) table.smooth(pull);
  table.print();
}
