// Phong surfaces against the BRDFs that they stand for, by quadrature over the directions of the light. With
// COPPICE_TABLES=1 in the environment the tables of docs/lobe.md are printed.
#include <doctest/doctest.h>

#include <array>
#include <coppice/brdf/with_brdf.hpp>
#include <coppice/lobe/phong_surface.hpp>
#include <coppice/reference/lobe.hpp>

#include "brdf/directions.hpp"
#include "lobe/tables.hpp"

using namespace coppice;
using brdf_test::random_direction;
using glm::dvec3;
using reference::sphere_nodes;
using reference::SphereNode;

namespace {

constexpr double alphas[] = {0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1};
constexpr double cosines[] = {1, 0.8, 0.6, 0.4, 0.2, 0.1};

struct Material {
  uint brdf;
  vec3 diffuse, specular, fresnel;
};
const Material metal{BRDF_GGX, vec3(0), vec3(1), vec3(1)};
const Material dielectric{BRDF_GGX, vec3(0), vec3(0.04f), vec3(1)};
const Material blinn_phong{BRDF_BLINN_PHONG, vec3(0), vec3(1), vec3(0)};
const Material ward{BRDF_WARD, vec3(0), vec3(1), vec3(0)};

/// In the local frame, seen at this cosine. Blinn-Phong takes the exponent of this width.
ShadingPoint point_of(const Material& material, double alpha_x, double alpha_y, double cosine) {
  ShadingPoint point{};
  point.normal = vec3(0, 0, 1), point.tangent = vec3(1, 0, 0);
  point.to_viewer = vec3(brdf_test::spherical(cosine, 0.7));
  point.brdf = material.brdf;
  const bool by_exponent = material.brdf == BRDF_BLINN_PHONG || material.brdf == BRDF_PHONG;
  point.alpha_x = float(by_exponent ? 2 / (alpha_x * alpha_x) - 2 : alpha_x);
  point.alpha_y = float(alpha_y);
  point.diffuse = material.diffuse, point.specular = material.specular, point.fresnel = material.fresnel;
  return point;
}

dvec3 mirror_of(const ShadingPoint& point) {
  return glm::normalize(dvec3(-point.to_viewer.x, -point.to_viewer.y, point.to_viewer.z));
}

/// Red of BRDF · cos.
double value_of(const ShadingPoint& point, const dvec3& d) {
  return with_brdf(point, [&](const auto& brdf) {
    return double(brdf.colour(brdf(float(d.x), float(d.y), float(d.z))).x);
  });
}
double value_of(const PhongSurface& s, const dvec3& mirror, const dvec3& d) {
  const auto n = double(s.exponent);
  const double lobe = (n + 2) / (n + 1) * reference::lobe_radiance(n, glm::dot(mirror, d));
  return (double(s.diffuse.x) * std::numbers::inv_pi + double(s.specular.x) * lobe) * std::max(0.0, d.z);
}

double to_the_50th(double x) {
  const double x2 = x * x, x8 = x2 * x2 * x2 * x2, x16 = x8 * x8;
  return x > 0 ? x16 * x16 * x16 * x2 : 0;
}

struct Comparison {
  double sharp = 0;    ///< ∫ |f - fit| / ∫ f
  double blurred = 0;  ///< the same after convolution with a Phong lobe of exponent 50
  double albedo = 0;   ///< that of the fit over that of f, less 1
};

Comparison compare(const ShadingPoint& point, double width) {
  const PhongSurface surface = phong_surface(point);
  const dvec3 mirror = mirror_of(point);
  auto nodes = sphere_nodes(mirror, 0.7 * width, 72, 40);
  std::erase_if(nodes, [](const SphereNode& n) { return n.direction.z <= 0; });
  std::vector<double> apart;
  Comparison c;
  double whole = 0, fit = 0;
  for (const SphereNode& n : nodes) {
    const double f = value_of(point, n.direction), g = value_of(surface, mirror, n.direction);
    apart.push_back((f - g) * n.weight);
    c.sharp += std::abs(f - g) * n.weight, whole += f * n.weight, fit += g * n.weight;
  }
  for (const SphereNode& source : sphere_nodes(mirror, std::max(0.15, width), 20, 16)) {
    double sum = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      sum += apart[i] * to_the_50th(glm::dot(source.direction, nodes[i].direction));
    c.blurred += std::abs(sum) * source.weight * 51 / (2 * std::numbers::pi);
  }
  return {c.sharp / whole, c.blurred / whole, fit / whole - 1};
}

using Rows = std::array<std::array<Comparison, std::size(cosines)>, std::size(alphas)>;

/// Widths up to `widest`; the others stay 0.
Rows rows_of(const Material& material, double widest = 1) {
  Rows rows{};
  for (std::size_t i = 0; i < rows.size() && alphas[i] <= widest; ++i)
    for (std::size_t j = 0; j < std::size(cosines); ++j)
      rows[i][j] = compare(point_of(material, alphas[i], alphas[i], cosines[j]), alphas[i]);
  return rows;
}

void print(const char* name, const Rows& rows) {
  lobe_test::Table table(std::string(name) + ": sharp / blurred / albedo, by the viewer's cosine", "alpha",
                         cosines);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    table.start_row(alphas[i]);
    for (const Comparison& c : rows[i]) table.add({c.sharp, c.blurred, c.albedo});
  }
  table.print();
}

/// The most over all widths, by the viewer's cosine.
using Limits = std::array<double, std::size(cosines)>;

void check(const Rows& rows, const Limits& sharp, const Limits& blurred, const Limits& albedo) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < std::size(cosines); ++j) {
      CAPTURE(alphas[i]);
      CAPTURE(cosines[j]);
      CHECK(rows[i][j].sharp <= sharp[j]);
      CHECK(rows[i][j].blurred <= blurred[j]);
      CHECK(std::abs(rows[i][j].albedo) <= albedo[j]);
    }
}

/// The least ∫ |f - fit| / ∫ f of a Phong lobe alone that has the point's albedo.
double error_of_best_lobe(const ShadingPoint& point, double width) {
  const float cosine = point.to_viewer.z;
  const PhongSurface surface = phong_surface(point);
  const float albedo = surface.diffuse.x + surface.specular.x * phong_albedo(surface.exponent, cosine);
  const auto nodes = sphere_nodes(mirror_of(point), 0.7 * width, 72, 40);
  double best = 2;
  for (int i = 0; i < 30; ++i) {
    PhongSurface alone{vec3(0), vec3(0), std::pow(1.2f, float(i))};
    alone.specular = vec3(albedo / phong_albedo(alone.exponent, cosine));
    double apart = 0, whole = 0;
    for (const SphereNode& n : nodes) {
      const double f = n.direction.z > 0 ? value_of(point, n.direction) : 0;
      apart += n.weight * std::abs(f - value_of(alone, mirror_of(point), n.direction)), whole += n.weight * f;
    }
    best = std::min(best, apart / whole);
  }
  return best;
}

bool is_sound(const PhongSurface& s) {
  return is_finite(s.diffuse) && is_finite(s.specular) && s.exponent >= 1 &&
         s.exponent <= BRDF_MAX_EXPONENT && s.diffuse.x >= 0 && s.specular.x >= 0;
}

}  // namespace

TEST_CASE("Lambert and Phong are their own Phong surfaces, exactly") {
  std::mt19937 random(1);
  for (const uint brdf : {BRDF_LAMBERT, BRDF_PHONG})
    for (const double width : {1e-2, 0.1, 0.5})
      for (const double cosine : {1.0, 0.5, 0.1}) {
        const Material material{brdf, vec3(0.3f), vec3(0.6f), vec3(0.5f)};
        const ShadingPoint point = point_of(material, width, width, cosine);
        const PhongSurface surface = phong_surface(point);
        CHECK(surface.diffuse == point.diffuse);
        CHECK(surface.specular == (brdf == BRDF_PHONG ? point.specular : vec3(0)));
        for (int i = 0; i < 100; ++i) {
          const dvec3 d = glm::normalize(0.3 * dvec3(random_direction(random)) + mirror_of(point));
          const double exact = value_of(point, d);
          CHECK(std::abs(value_of(surface, mirror_of(point), d) - exact) <= 1e-4 * exact + 1e-6);
        }
      }
}

TEST_CASE("a metal's Phong surface has its albedo and its lobe as near as stated") {
  const Rows rows = rows_of(metal);
  print("GGX metal", rows);
  check(rows, {0.33, 0.38, 0.49, 0.68, 1.06, 1.4}, {0.13, 0.2, 0.24, 0.3, 0.4, 0.46},
        {0.008, 0.007, 0.007, 0.006, 0.013, 0.018});
}

TEST_CASE("a dielectric's Phong surface has its albedo and its lobe as near as stated") {
  const Rows rows = rows_of(dielectric);
  print("GGX dielectric", rows);
  check(rows, {0.33, 0.39, 0.53, 0.71, 1.05, 1.42}, {0.13, 0.23, 0.38, 0.46, 0.54, 0.65},
        {0.009, 0.01, 0.012, 0.017, 0.026, 0.024});
}

TEST_CASE("Blinn-Phong's Phong surface has its albedo and its lobe as near as stated") {
  const Rows rows = rows_of(blinn_phong, 0.8);
  print("Blinn-Phong", rows);
  check(rows, {0.02, 0.16, 0.34, 0.61, 1.1, 1.5}, {0.015, 0.12, 0.26, 0.44, 0.64, 0.73},
        {0.002, 0.012, 0.017, 0.018, 0.036, 0.048});
}

TEST_CASE("isotropic Ward's Phong surface has its albedo and its lobe as near as stated") {
  const Rows rows = rows_of(ward);
  print("Ward", rows);
  check(rows, {0.24, 0.25, 0.35, 0.6, 0.96, 1.26}, {0.23, 0.23, 0.25, 0.34, 0.46, 0.54},
        {0.008, 0.008, 0.007, 0.008, 0.016, 0.026});
}

TEST_CASE("a rough metal is nearer to a lobe and a Lambert term than to a lobe alone") {
  for (const double alpha : {0.2, 0.3, 0.5, 0.7})
    for (const double cosine : {1.0, 0.8, 0.6, 0.4}) {
      const ShadingPoint point = point_of(metal, alpha, alpha, cosine);
      CHECK(phong_surface(point).diffuse.x > 0.05f);
      CHECK(compare(point, alpha).sharp <= error_of_best_lobe(point, alpha));
    }
}

TEST_CASE("anisotropic Ward is fitted at its mean width") {
  const ShadingPoint point = point_of(ward, 0.1, 0.3, 0.8);
  const ShadingPoint mean = point_of(ward, std::sqrt(0.03), std::sqrt(0.03), 0.8);
  CHECK(phong_surface(point).exponent == doctest::Approx(phong_surface(mean).exponent).epsilon(1e-5));
  const Comparison c = compare(point, std::sqrt(0.03));
  CAPTURE(c.sharp);
  CAPTURE(c.blurred);
  CHECK(c.sharp <= 0.68);
  CHECK(c.blurred <= 0.49);
  CHECK(std::abs(c.albedo) <= 0.03);
}

TEST_CASE("GGX's diffuse term keeps its albedo under Fresnel") {
  const Material diffuse{BRDF_GGX, vec3(0.8f), vec3(0), vec3(0)};
  for (const double cosine : {1.0, 0.9, 0.7, 0.5, 0.3, 0.1, 0.01}) {
    const ShadingPoint point = point_of(diffuse, 0.3, 0.3, cosine);
    double albedo = 0;
    for (const SphereNode& n : sphere_nodes({0, 0, 1}, 3, 200, 60))
      if (n.direction.z > 0) albedo += n.weight * value_of(point, n.direction);
    CHECK(double(phong_surface(point).diffuse.x) == doctest::Approx(albedo).epsilon(1.5e-3));
  }
}

TEST_CASE("Phong surfaces are finite, and within their domain, for every width and viewer") {
  for (const uint brdf : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD})
    for (const double alpha : {0.0, 1e-3, 0.0156, 0.0157, 0.3, 0.999, 1.0, 2.0, 100.0, 1e6})
      for (const double cosine : {-0.5, 0.0, 1e-4, 0.0156, 0.5, 0.9999, 1.0}) {
        ShadingPoint point = point_of({brdf, vec3(0.5f), vec3(0.5f), vec3(1)}, 0.1, alpha, cosine);
        point.alpha_x = float(alpha);
        CHECK(is_sound(phong_surface(point)));
      }
}

TEST_CASE("a Phong surface is linear in the colours, and narrows with its BRDF") {
  for (const Material& material : {metal, blinn_phong, ward})
    for (const double cosine : cosines) {
      float last = BRDF_MAX_EXPONENT;
      for (const double alpha : {4e-3, 0.01, 0.03, 0.1, 0.2, 0.4, 0.6}) {
        ShadingPoint point = point_of(material, alpha, alpha, cosine);
        const PhongSurface white = phong_surface(point);
        point.specular *= 0.5f, point.fresnel *= 0.5f;
        const PhongSurface grey = phong_surface(point);
        CHECK(grey.specular.x == doctest::Approx(white.specular.x / 2).epsilon(1e-6));
        CHECK(grey.diffuse.x == doctest::Approx(white.diffuse.x / 2).epsilon(1e-6));
        CHECK(grey.exponent == white.exponent);
        if (cosine >= 0.4) CHECK(white.exponent <= last);
        last = white.exponent;
      }
    }
}
