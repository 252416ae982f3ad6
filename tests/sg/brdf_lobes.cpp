// BRDFs as Gaussians against quadrature over the hemisphere. With COPPICE_TABLES=1 in the environment the
// tables of docs/sg_materials.md are printed.
#include <doctest/doctest.h>

#include <array>

#include "lobe/tables.hpp"
#include "sg/brdf_slices.hpp"
#include "support/generators.hpp"

using namespace sg_test;

namespace {

constexpr double alphas[] = {0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1};
constexpr double cosines[] = {1, 0.8, 0.6, 0.4, 0.2, 0.1, 0.03};
using Rows = std::array<std::array<FitErrors, std::size(cosines)>, std::size(alphas)>;

Rows rows_of(uint kind, LobeFit fit) {
  Rows rows{};
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < std::size(cosines); ++j) {
      const Slice slice{kind, alphas[i], cosines[j]};
      rows[i][j] = errors_of(slice, slice.lobes(fit));
    }
  return rows;
}

template <class Cell>
void print(const std::string& title, const Rows& rows, Cell cell) {
  lobe_test::Table table(title, "alpha", cosines);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    table.start_row(alphas[i]);
    for (const FitErrors& e : rows[i]) cell(table, e);
  }
  table.print();
}

void print(const std::string& name, const Rows& rows) {
  print(name + ": sharp / λ = 50 / λ = 5, by the viewer's cosine", rows,
        [](lobe_test::Table& table, const FitErrors& e) {
          table.add({e.sharp, e.at_50, e.at_5});
        });
  print(name + ": energy / closed forms at 50 / at 5", rows, [](lobe_test::Table& table, const FitErrors& e) {
    table.add({e.energy, e.forms_50, e.forms_5});
  });
  print(name + ": below the horizon uncut / lights below, uncut / cut", rows,
        [](lobe_test::Table& table, const FitErrors& e) {
          table.add({e.below, e.leak_uncut, e.leak_cut});
        });
}

/// The most over all widths, by the viewer's cosine.
using Limits = std::array<double, std::size(cosines)>;

void check(const Rows& rows, const Limits& sharp, const Limits& at_50, const Limits& at_5, double energy) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < std::size(cosines); ++j) {
      CAPTURE(alphas[i]);
      CAPTURE(cosines[j]);
      const FitErrors& e = rows[i][j];
      CHECK(e.sharp <= sharp[j]);
      CHECK(e.at_50 <= at_50[j]);
      CHECK(e.at_5 <= at_5[j]);
      CHECK(std::abs(e.energy) <= energy);
      CHECK(e.leak_cut <= e.at_50);
    }
}

/// A lobe's Gaussian alone.
BrdfLobes alone(const BrdfLobes& lobes, int k) {
  BrdfLobes one = lobes;
  one.count = 1, one.lobes[0] = lobes.lobes[std::size_t(k)];
  return one;
}

/// Relative L2 errors over the directions of the light.
struct TermErrors {
  double metal = 0;       ///< specular + fresnel
  double dielectric = 0;  ///< 0.04 specular + fresnel
  double diffuse = 0;
};

TermErrors term_errors(const Slice& slice, float sharpness) {
  const auto nodes = slice.nodes(80, 64), even = reference::sphere_nodes({0, 0, 1}, 1, 60, 60);
  const BrdfLobes lobes = slice.lobes();
  TermErrors apart, norm;
  for (const SphereNode& s : reference::sphere_nodes(slice.mirror(), std::max(slice.alpha, 0.2), 10, 12)) {
    const SgShape light{vec3(s.direction), sharpness};
    const BrdfTerms<float> form = gaussian_terms(lobes, light);
    const auto add = [&](const std::vector<SphereNode>& over, const dvec3& colours,
                         double TermErrors::*error) {
      const double sum = glm::dot(colours, dvec3(form.diffuse, form.specular, form.fresnel));
      const double exact = reference::integral_with_light(over, light, [&](const dvec3& d) {
        const BrdfTerms<double> t = slice.terms(d);
        return d.z > 0 ? glm::dot(colours, dvec3(t.diffuse, t.specular, t.fresnel)) : 0;
      });
      apart.*error += s.weight * (sum - exact) * (sum - exact);
      norm.*error += s.weight * exact * exact;
    };
    add(nodes, {0, 1, 1}, &TermErrors::metal);
    add(nodes, {0, 0.04, 1}, &TermErrors::dielectric);
    add(even, {1, 0, 0}, &TermErrors::diffuse);
  }
  return {std::sqrt(apart.metal / norm.metal), std::sqrt(apart.dielectric / norm.dielectric),
          std::sqrt(apart.diffuse / norm.diffuse)};
}

double worst(const Rows& rows, double FitErrors::*field) {
  double most = 0;
  for (const auto& row : rows)
    for (const FitErrors& e : row) most = std::max(most, std::abs(e.*field));
  return most;
}

}  // namespace

TEST_CASE("GGX's Gaussians have its energy and its lobe as near as stated, and the warped one has not") {
  const Rows fitted = rows_of(BRDF_GGX, LobeFit::fitted), warped = rows_of(BRDF_GGX, LobeFit::warped);
  print("GGX, fitted", fitted), print("GGX, warped", warped);
  check(fitted, {0.15, 0.15, 0.155, 0.155, 0.155, 0.15, 0.215}, {0.1, 0.1, 0.1, 0.1, 0.092, 0.078, 0.105},
        {0.03, 0.03, 0.03, 0.03, 0.034, 0.055, 0.078}, 0.012);
  CHECK(worst(fitted, &FitErrors::forms_50) <= 0.012);
  CHECK(worst(fitted, &FitErrors::forms_5) <= 0.01);
  for (std::size_t i = 0; i < fitted.size(); ++i)
    for (std::size_t j = 0; j < std::size(cosines); ++j) {
      CHECK(fitted[i][j].sharp < warped[i][j].sharp);
      CHECK(warped[i][j].sharp >= 0.2);
    }
}

TEST_CASE("Blinn-Phong's Gaussians have its energy and its lobe as near as stated") {
  const Rows rows = rows_of(BRDF_BLINN_PHONG, LobeFit::fitted);
  print("Blinn-Phong, fitted", rows),
      print("Blinn-Phong, warped", rows_of(BRDF_BLINN_PHONG, LobeFit::warped));
  check(rows, {0.12, 0.12, 0.12, 0.12, 0.12, 0.12, 0.13}, {0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1},
        {0.035, 0.035, 0.035, 0.035, 0.04, 0.04, 0.045}, 0.03);
  CHECK(worst(rows, &FitErrors::forms_50) <= 0.008);
}

TEST_CASE("Ward's Gaussians have its energy and its lobe as near as stated") {
  const Rows rows = rows_of(BRDF_WARD, LobeFit::fitted);
  print("Ward, fitted", rows), print("Ward, warped", rows_of(BRDF_WARD, LobeFit::warped));
  check(rows, {0.19, 0.2, 0.21, 0.22, 0.24, 0.26, 0.34}, {0.13, 0.14, 0.15, 0.16, 0.16, 0.155, 0.17},
        {0.04, 0.045, 0.05, 0.05, 0.05, 0.05, 0.055}, 0.02);
  CHECK(worst(rows, &FitErrors::forms_50) <= 0.025);
}

TEST_CASE("Phong's Gaussians have its energy and its lobe as near as stated") {
  const Rows rows = rows_of(BRDF_PHONG, LobeFit::fitted);
  print("Phong, fitted", rows), print("Phong, warped", rows_of(BRDF_PHONG, LobeFit::warped));
  check(rows, {0.07, 0.085, 0.1, 0.12, 0.14, 0.15, 0.16}, {0.06, 0.07, 0.08, 0.1, 0.12, 0.13, 0.14},
        {0.04, 0.04, 0.045, 0.05, 0.06, 0.065, 0.07}, 0.05);
  CHECK(worst(rows, &FitErrors::forms_50) <= 0.003);
}

TEST_CASE("Lambert's lobe is the cosine, exactly") {
  const BrdfLobes lobes = lambert_lobes(vec3(0, 0, 1));
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const vec3 d = random.direction();
    CHECK(lobes_value(lobes, d) == doctest::Approx(std::max(d.z, 0.0f) / pi));
  }
  CHECK(lobes_integral(lobes, {vec3(0, 0, 1), 0}) == doctest::Approx(1).epsilon(2e-4));
}

TEST_CASE("the integral of one elongated Gaussian above the horizon is that of quadrature") {
  Random random(3);
  double most = 0;
  for (int i = 0; i < 150; ++i) {
    const double alpha = std::exp(std::log(0.03) * double(random.uniform()));
    const Slice slice{BRDF_GGX, alpha, 0.02 + 0.98 * double(random.uniform())};
    const BrdfLobes lobes = slice.lobes();
    for (int k = 0; k < lobes.count; ++k) {
      const BrdfLobes one = alone(lobes, k);
      const auto nodes = slice.nodes(160, 96);
      const auto value = [&](const dvec3& d) { return reference::value(one, d); };
      const float energy = lobe_energy(one, one.lobes[0]);
      CHECK(std::abs(reference::integrate(nodes, value) / double(energy) - 1) <= 0.03);
      const vec3 near = normalize(one.lobes[0].shape.axis + 0.5f * random.direction());
      const SgShape light{near, 3 * std::exp(3 * random.uniform())};
      const double exact = reference::integral_with_light(nodes, light, value);
      const double apart = std::abs(double(lobes_integral(one, light)) - exact) /
                           double(std::min(energy, one.lobes[0].amplitude * sg_integral(light.sharpness)));
      most = std::max(most, apart);
    }
  }
  CHECK(most <= 0.03);
}

TEST_CASE("no lobe answers light from below the horizon") {
  for (const uint kind : {BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD})
    for (const double alpha : {0.02, 0.1, 0.3, 0.7, 1.0})
      for (const double cosine : {1.0, 0.5, 0.1, 0.02})
        for (const LobeFit fit : {LobeFit::fitted, LobeFit::warped}) {
          const Slice slice{kind, alpha, cosine};
          const BrdfLobes lobes = slice.lobes(fit);
          CHECK(lobes_value(lobes, vec3(0.6f, 0, -0.8f)) == 0);
          CHECK(lobes_value(lobes, vec3(1, 0, 0)) == 0);
          const vec3 mirror(slice.mirror());
          const vec3 low = normalize(vec3(mirror.x, mirror.y, 0) + vec3(1e-3f, 0, -0.35f));
          const float seen = lobes_integral(lobes, {vec3(0, 0, 1), 0});
          CHECK(std::abs(lobes_integral(lobes, {low, 300})) <= 1e-5f * std::max(seen, 1e-2f));
        }
}

TEST_CASE("Gaussians change smoothly with the width and the viewer") {
  Random random(5);
  for (const uint kind : {BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD})
    for (int i = 0; i < 60; ++i) {
      const double alpha = std::exp(std::log(0.004) * double(random.uniform())), azimuth = 0.4;
      const bool along_alpha = i % 2 == 0;
      const double start = 0.01 + 0.98 * double(random.uniform());
      const vec3 axis =
          normalize(vec3(Slice{kind, alpha, start, azimuth}.mirror()) + 0.3f * random.direction());
      const SgShape light{axis, 4 + 40 * random.uniform()};
      double before = -1;
      for (int step = 0; step < 40; ++step) {
        const double t = step * 2.5e-3, angle = std::acos(start) + step * 1e-3;
        const Slice slice{kind, along_alpha ? std::min(alpha * std::exp(t), 1.0) : alpha,
                          along_alpha ? start : std::max(std::cos(angle), 1e-3), azimuth};
        const double now = double(lobes_integral(slice.lobes(), light)),
                     scale = double(sg_integral(light.sharpness));
        if (before >= 0) CHECK(std::abs(now - before) <= 0.02 * std::max(now, before) + 1e-3 * scale);
        before = now;
      }
    }
}

TEST_CASE("Gaussians turn with the viewer about the normal") {
  for (const uint kind : {BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD})
    for (const double cosine : {1.0, 0.999999, 0.7, 0.1}) {
      const Slice a{kind, 0.15, cosine, 0}, b{kind, 0.15, cosine, 2};
      Random random(7);
      for (int i = 0; i < 20; ++i) {
        const vec3 d = random.direction();
        const float c = std::cos(2.0f), s = std::sin(2.0f);
        const vec3 turned(c * d.x - s * d.y, s * d.x + c * d.y, d.z);
        const float first = lobes_integral(a.lobes(), {d, 20}),
                    second = lobes_integral(b.lobes(), {turned, 20});
        CHECK(std::abs(first - second) <= 2e-3f * first + 1e-6f);
      }
    }
}

TEST_CASE("the warped Gaussian has the BRDF's height in the mirror direction") {
  for (const uint kind : {BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD}) {
    const Slice slice{kind, 0.3, 0.6};
    const double exact = slice(slice.mirror());
    CHECK(double(lobes_value(slice.lobes(LobeFit::warped), vec3(slice.mirror()))) ==
          doctest::Approx(exact).epsilon(1e-3));
  }
}

TEST_CASE(
    "metals and dielectrics against Gaussian light are as near as stated, Fresnel and diffuse included") {
  lobe_test::Table table("GGX with Fresnel, λ = 20: metal / dielectric's lobe / diffuse", "alpha", cosines);
  for (const double alpha : {0.05, 0.1, 0.2, 0.3, 0.5, 1.0}) {
    table.start_row(alpha);
    for (const double cosine : cosines) {
      const TermErrors e = term_errors({BRDF_GGX, alpha, cosine}, 20);
      table.add({e.metal, e.dielectric, e.diffuse});
      CAPTURE(alpha);
      CAPTURE(cosine);
      CHECK(e.metal <= 0.15);
      CHECK(e.dielectric <= 0.3);
      CHECK(e.diffuse <= 0.06);
    }
  }
  table.print();
}

TEST_CASE("lobes and integrals are numbers at the extremes") {
  Random random(11);
  for (const uint kind : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD, 77u})
    for (const float parameter : {0.0f, 1e-3f, 0.5f, 1.0f, 1e5f, 1e30f})
      for (const vec3& viewer :
           {vec3(0, 0, 1), vec3(1, 0, 0), vec3(0, 1, -1e-3f), vec3(0.6f, 0, 0.8f), vec3(0, 0, -1)})
        for (const LobeFit fit : {LobeFit::fitted, LobeFit::warped}) {
          const BrdfLobes lobes = brdf_lobes(kind, parameter, parameter, viewer, fit);
          CHECK((kind == BRDF_LAMBERT || kind > BRDF_WARD) == (lobes.count == 0));
          for (int k = 0; k < lobes.count; ++k) {
            const BrdfLobe& lobe = lobes.lobes[std::size_t(k)];
            CHECK(is_finite(lobe.shape.axis));
            CHECK(lobe.shape.axis.z >= 0);
            CHECK(std::isfinite(lobe.amplitude));
            CHECK(lobe.stripe >= 0);
          }
          for (const float sharpness : {0.0f, 1e-6f, 1.0f, 1e5f, 1e10f})
            for (int i = 0; i < 4; ++i) {
              const vec3 axis = i == 0 ? lobes.lobes[0].shape.axis : random.direction();
              const SgShape light{length(axis) > 0.5f ? axis : vec3(0, 0, 1), sharpness};
              const float value = lobes_integral(lobes, light);
              CHECK(std::isfinite(value));
              CHECK((value >= 0 || kind == BRDF_PHONG));
              const BrdfTerms<float> terms = gaussian_terms(lobes, light);
              CHECK(std::isfinite(terms.diffuse + terms.specular + terms.fresnel));
            }
        }
}
