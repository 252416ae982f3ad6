// A white surface in a white furnace returns no more than it receives, from every side.
#include <doctest/doctest.h>

#include <coppice/brdf/with_brdf.hpp>

#include "brdf/directions.hpp"

using namespace coppice;
using namespace brdf_test;

namespace {

constexpr double viewer_cosines[] = {1, 0.95, 0.8, 0.6, 0.4, 0.2, 0.1, 0.05, 0.02, 1e-2, 1e-3};
constexpr float widths[] = {1e-3f, 1e-2f, 0.1f, 0.3f, 1};
constexpr float exponents[] = {1, 2, 5, 20, 100, 1000, 1e5f};

vec3 viewer_at(double cosine) { return vec3(spherical(cosine, 0.7)); }

/// The cosine-weighted red of the BRDF at wi.
template <class B>
auto red_of(const B& brdf) {
  return [brdf](const vec3& wi) { return brdf.colour(brdf(wi.x, wi.y, wi.z)).x; };
}

SeenSurface diffuse_only(double cosine) { return {viewer_at(cosine), vec3(1), vec3(0), vec3(0)}; }
SeenSurface specular_only(double cosine) { return {viewer_at(cosine), vec3(0), vec3(1), vec3(0)}; }
SeenSurface mirror(double cosine) { return {viewer_at(cosine), vec3(0), vec3(1), vec3(1)}; }

}  // namespace

TEST_CASE("white Lambert returns exactly what it receives") {
  for (const double cosine : viewer_cosines)
    CHECK(integral_about_mirror(vec3(0, 0, 1), 1, 100, red_of(Lambert(diffuse_only(cosine)))) ==
          doctest::Approx(1).epsilon(1e-6));
}

TEST_CASE("white metal returns at most what it receives, and all of it where it is smooth") {
  for (const double cosine : viewer_cosines)
    for (const float alpha : widths) {
      CAPTURE(cosine);
      CAPTURE(alpha);
      const double albedo =
          integral_over_half_vectors(viewer_at(cosine), alpha, 200, red_of(Ggx(mirror(cosine), alpha)));
      CHECK(albedo <= 1.002);
      if (alpha <= 0.01f && cosine >= 0.1) CHECK(albedo >= 0.98);
    }
}

TEST_CASE("the diffuse part of a dielectric returns less than it receives") {
  for (const double cosine : viewer_cosines) {
    const double albedo =
        integral_over_half_vectors(viewer_at(cosine), 1, 200, red_of(Ggx(diffuse_only(cosine), 0.1f)));
    CHECK(albedo < 1);
    CHECK(albedo > 0.8);
  }
}

TEST_CASE("a white dielectric makes as much energy at grazing angles as documented, and no more") {
  ShadingPoint point{};
  double worst = 0;
  for (const float roughness : {0.03f, 0.1f, 0.3f, 0.6f, 1.0f}) {
    set_metallic_roughness(point, vec3(1), 0, roughness);
    for (const double cosine : viewer_cosines) {
      const auto red = [&](const vec3& colour0, const vec3& colour1, const vec3& colour2, double width) {
        const SeenSurface surface{viewer_at(cosine), colour0, colour1, colour2};
        return integral_over_half_vectors(surface.viewer, width, 200, red_of(Ggx(surface, point.alpha_x)));
      };
      const double albedo = red(point.diffuse, vec3(0), vec3(0), 1) +
                            red(vec3(0), point.specular, point.fresnel, point.alpha_x);
      worst = std::max(worst, albedo);
    }
  }
  CHECK(worst == doctest::Approx(1.9).epsilon(0.05));
}

TEST_CASE("Phong returns at most what it receives, and all of it from straight above") {
  for (const float exponent : exponents) {
    CAPTURE(exponent);
    for (const double cosine : viewer_cosines) {
      CAPTURE(cosine);
      const double albedo = integral_about_mirror(viewer_at(cosine), exponent, 200,
                                                  red_of(Phong(specular_only(cosine), exponent)));
      CHECK(albedo <= 1.001);
      if (cosine == 1) CHECK(albedo >= 0.999);
    }
  }
}

TEST_CASE("Blinn-Phong returns at most what it receives, and all of it from straight above") {
  for (const float exponent : exponents) {
    CAPTURE(exponent);
    for (const double cosine : viewer_cosines) {
      CAPTURE(cosine);
      const double width = std::sqrt(2.0 / (exponent + 2));
      const double albedo = integral_over_half_vectors(viewer_at(cosine), width, 200,
                                                       red_of(BlinnPhong(specular_only(cosine), exponent)));
      CHECK(albedo <= 1.002);
      if (cosine == 1) CHECK(albedo >= 0.998);
    }
  }
}

TEST_CASE("Ward returns at most what it receives, isotropic and not") {
  for (const float alpha_x : widths)
    for (const float alpha_y : {alpha_x, std::min(1.0f, 4 * alpha_x)})
      for (const double cosine : viewer_cosines) {
        CAPTURE(alpha_x);
        CAPTURE(alpha_y);
        CAPTURE(cosine);
        const double width = std::max(alpha_x, alpha_y);
        const double albedo = integral_over_half_vectors(
            viewer_at(cosine), width, 300, red_of(Ward(specular_only(cosine), alpha_x, alpha_y)));
        CHECK(albedo <= 1.005);
        if (cosine == 1 && width <= 0.01) CHECK(albedo >= 0.99);
      }
}
