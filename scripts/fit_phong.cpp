// Fits a Phong lobe and a Lambert term to GGX, Blinn-Phong and Ward; prints the rows of
// include/coppice/lobe/phong_table.hpp.
//
//     c++ -std=c++20 -O3 -I include scripts/fit_phong.cpp -o fit_phong && ./fit_phong
//
// Rows: sqrt(alpha) = 0, 1/8 … 1, columns: sqrt(cosine of the viewer) = 0, 1/8 … 1; of Blinn-Phong alpha² =
// 2/(exponent + 2). The first of each are
// fitted at alpha 0.004 and cosine 0.005. A fit has the albedo of what it stands for. Its exponent and the
// share of Lambert minimise E(0) + E(50): E(k) is ∫|f - fit| / ∫f over directions of the light, of the
// functions times the cosine, after their convolution with a Phong lobe of exponent k (0: as they are).
#include <coppice/shared/brdf.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

namespace {

using coppice::vec3;
using glm::dvec3;
using std::numbers::pi;

constexpr int steps = 8;
constexpr double source_exponent = 50;

struct Node {
  dvec3 direction;
  double weight;  ///< solid angle
  double mirror;  ///< cosine to the mirror direction
};

/// Directions over half the sphere (all is even in y), dense within `width` of the mirror direction.
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
      nodes.push_back({mirror * std::cos(angle) + across * std::sin(angle), weight, std::cos(angle)});
    }
  return nodes;
}

double phong(double exponent, double cosine) {
  return cosine > 0 ? std::exp(exponent * std::log(cosine)) / (2 * pi) : 0;
}

/// What a source of exponent 50 in the middle of each of `to` gives: a matrix over nodes, rows by `to`.
std::vector<float> blur_matrix(const std::vector<Node>& from, const std::vector<Node>& to) {
  std::vector<float> matrix;
  for (const Node& t : to)
    for (const Node& f : from) {
      const dvec3 other(f.direction.x, -f.direction.y, f.direction.z);
      const double lobe = phong(source_exponent, glm::dot(t.direction, f.direction)) +
                          phong(source_exponent, glm::dot(t.direction, other));
      matrix.push_back(float(0.5 * (source_exponent + 1) * lobe * f.weight));
    }
  return matrix;
}

struct Sampled {
  std::vector<double> sharp, blurred;
  double albedo = 0;
};

/// Where both errors are measured, for one width and viewer.
class Bench {
 public:
  Bench(double cosine, double width)
      : nodes_(nodes_about_mirror(cosine, width, 72, 24)),
        far_(nodes_about_mirror(cosine, std::max(width, 0.15), 28, 16)) {
    std::erase_if(nodes_, [](const Node& n) { return n.direction.z <= 0; });
    matrix_ = blur_matrix(nodes_, far_);
  }

  template <class F>
  Sampled sample(F f) const {
    Sampled s;
    for (const Node& n : nodes_) {
      s.sharp.push_back(f(n));
      s.albedo += s.sharp.back() * n.weight;
    }
    for (std::size_t i = 0; i < far_.size(); ++i) {
      float sum = 0;
      for (std::size_t j = 0; j < nodes_.size(); ++j)
        sum += matrix_[i * nodes_.size() + j] * float(s.sharp[j]);
      s.blurred.push_back(double(sum));
    }
    return s;
  }

  /// E(0) + E(50) of (1 - share) lobe + share · flat, each brought to the albedo of f.
  double error(const Sampled& f, const Sampled& lobe, const Sampled& flat, double share) const {
    const double a = (1 - share) * f.albedo / lobe.albedo, b = share * f.albedo / flat.albedo;
    double sharp = 0, blurred = 0, all = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      sharp += std::abs(f.sharp[i] - a * lobe.sharp[i] - b * flat.sharp[i]) * nodes_[i].weight;
    for (std::size_t i = 0; i < far_.size(); ++i) {
      blurred += std::abs(f.blurred[i] - a * lobe.blurred[i] - b * flat.blurred[i]) * far_[i].weight;
      all += f.blurred[i] * far_[i].weight;
    }
    return sharp / f.albedo + blurred / all;
  }

 private:
  std::vector<Node> nodes_, far_;
  std::vector<float> matrix_;
};

/// ∫ f over directions of the light, by half vectors drawn from a GGX lobe of this width.
template <class F>
double integral(double cosine, double width, F f) {
  constexpr int side = 400;
  const dvec3 viewer(std::sqrt(1 - cosine * cosine), 0, cosine);
  double sum = 0;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const double u = (i + 0.5) / side, turn = pi * (j + 0.5) / side, tangent2 = width * width * u / (1 - u);
      const double z = 1 / std::sqrt(1 + tangent2), r = z * std::sqrt(tangent2);
      const dvec3 h(r * std::cos(turn), r * std::sin(turn), z);
      const dvec3 light = 2 * glm::dot(h, viewer) * h - viewer;
      if (light.z <= 0 || glm::dot(h, viewer) <= 0) continue;
      const double t = width / (z * z * (width * width + tangent2));
      sum += f(light) * 4 * glm::dot(h, viewer) * pi / (t * t * z);
    }
  return sum / (side * side);
}

/// The x in [low, high] where f, with one valley, is least.
template <class F>
double argmin(double low, double high, int rounds, F f) {
  constexpr double golden = 0.6180339887498949;
  double x1 = high - golden * (high - low), x2 = low + golden * (high - low), f1 = f(x1), f2 = f(x2);
  for (int i = 0; i < rounds; ++i) {
    if (f1 < f2) {
      high = std::exchange(x2, x1), f2 = f1;
      f1 = f(x1 = high - golden * (high - low));
    } else {
      low = std::exchange(x1, x2), f1 = f2;
      f2 = f(x2 = low + golden * (high - low));
    }
  }
  return f1 < f2 ? x1 : x2;
}

/// The same where f may have several valleys.
template <class F>
double argmin_of_many(double low, double high, F f) {
  constexpr int tries = 24;
  const double step = (high - low) / tries;
  double best = low;
  for (int i = 1; i <= tries; ++i)
    if (f(low + i * step) < f(best)) best = low + i * step;
  return argmin(std::max(low, best - step), std::min(high, best + step), 14, f);
}

/// The best exponent and share of Lambert; where Lambert stands almost alone the exponent leans to a guess.
std::pair<double, double> fit(const Bench& bench, const Sampled& f, double width) {
  const Sampled flat = bench.sample([](const Node& n) { return n.direction.z / pi; });
  const double guess = std::log(1 + 0.5 / (width * width));
  const auto lobe_of = [&](double exponent) {
    return bench.sample([&](const Node& n) { return phong(exponent, n.mirror) * n.direction.z; });
  };
  const auto share_of = [&](const Sampled& lobe) {
    return argmin(0, 1, 12, [&](double share) { return bench.error(f, lobe, flat, share); });
  };
  const double best = argmin_of_many(0, std::log(8 / (width * width) + 2), [&](double x) {
    const Sampled lobe = lobe_of(std::exp(x));
    return bench.error(f, lobe, flat, share_of(lobe)) + 1e-3 * (x - guess) * (x - guess);
  });
  return {std::exp(best), share_of(lobe_of(std::exp(best)))};
}

void print_entry(coppice::uint kind, double width, double cosine) {
  const vec3 viewer(float(std::sqrt(1 - cosine * cosine)), 0, float(cosine));
  const float parameter = float(kind == coppice::BRDF_BLINN_PHONG ? 2 / (width * width) - 2 : width);
  const auto terms = [&](const dvec3& d) {
    return coppice::brdf_terms<double>(kind, parameter, parameter, d.x, d.y, d.z, viewer);
  };
  const auto lobe = [&](const dvec3& d) { return terms(d).specular + terms(d).fresnel; };
  const Bench bench(cosine, width);
  const auto [exponent, share] =
      fit(bench, bench.sample([&](const Node& n) { return lobe(n.direction); }), width);
  const double albedo = integral(cosine, width, lobe);
  const double fresnel = integral(cosine, width, [&](const dvec3& d) { return terms(d).fresnel; });
  std::printf("{%#.3gf, %#.3gf, %#.3gf, %#.3gf}, ", 1 / (exponent * width * width), std::sqrt(albedo),
              share < 2e-3 ? 0 : share, std::pow(fresnel / albedo, 0.2));
}

void print_table(const char* name, coppice::uint kind) {
  std::printf("// %s\n", name);
  for (int i = 0; i <= steps; ++i) {
    const double width = std::max(double(i * i) / (steps * steps), 4e-3);
    std::printf("{");
    for (int j = 0; j <= steps; ++j)
      print_entry(kind, width, std::max(double(j * j) / (steps * steps), 5e-3));
    std::printf("},\n");
  }
}

/// What 1 - Schlick's weight, the factor of a dielectric's diffuse term, leaves of Lambert's albedo 1.
void print_diffuse_albedo() {
  for (int j = 0; j <= 20; ++j) {
    const double cosine = std::max(j / 20.0, 1e-3);
    const vec3 viewer(float(std::sqrt(1 - cosine * cosine)), 0, float(cosine));
    std::printf("// diffuse albedo at %.2f: %.5f\n", cosine, integral(cosine, 1, [&](const dvec3& d) {
                  return coppice::brdf_terms<double>(coppice::BRDF_GGX, 1, 1, d.x, d.y, d.z, viewer).diffuse;
                }));
  }
}

}  // namespace

int main() {
  print_table("GGX", coppice::BRDF_GGX);
  print_table("Blinn-Phong", coppice::BRDF_BLINN_PHONG);
  print_table("Ward", coppice::BRDF_WARD);
  print_diffuse_albedo();
}
