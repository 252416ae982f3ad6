// The bound of what a light brings to a lobe: above the exact value everywhere, and of use.
#include <doctest/doctest.h>

#include <coppice/reference/environment_fit.hpp>
#include <coppice/sg/light_bound.hpp>
#include <coppice/sg/peaks.hpp>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

/// ∫ G₁G₂ in double, for axes of this cosine.
double exact(double a, double b, double cosine) {
  const double length = std::sqrt(std::max(0.0, a * a + b * b + 2 * a * b * cosine)), sum = a + b;
  const double integral = 2 * std::numbers::pi * (length > 1e-9 ? -std::expm1(-2 * length) / length : 2);
  return std::exp(-a * b * 2 * (1 - cosine) / (length + sum)) * integral;
}

}  // namespace

TEST_CASE("no light brings a Gaussian lobe more than its bound") {
  rc::check([] {
    Random random = any_random();
    const float a = std::exp(24 * random.uniform() - 8), b = std::exp(24 * random.uniform() - 8);
    const SgLight light = sg_light({vec3(0, 1, 0), a}, vec3(3));
    const SgLightBound bound(a, b);
    for (int i = 0; i < 50; ++i) {
      const float cosine = i < 25 ? 2 * random.uniform() - 1 : 1 - std::exp(-20 * random.uniform()) / 2;
      const double value = 3 * exact(double(a), double(b), double(cosine));
      if (value < 1e-30) continue;
      RC_ASSERT(double(bound.at(cosine, light.luminance)) >= value * (1 - 1e-5));
    }
  });
}

TEST_CASE("nor one of Phong or Lambert, whose lobes lie below Gaussians") {
  for (const double exponent : {1.0, 5.0, 50.0})
    for (const double sharpness : {4.0, 60.0, 250.0, 5000.0}) {
      const SgLight light = sg_light({vec3(0, 1, 0), float(sharpness)}, vec3(1));
      const SgLightBound bound{float(sharpness), float(exponent)};
      for (int i = 0; i <= 40; ++i) {
        const double angle = std::numbers::pi * i / 40;
        const double value = reference::convolve_gaussian(sharpness, angle, exponent);
        REQUIRE(double(bound.at(float(std::cos(angle)), light.luminance)) >= value * 0.9999 - 1e-30);
      }
    }
}

TEST_CASE("a power of the cosine lies below the Gaussian of that sharpness") {
  for (const double exponent : {1.0, 5.0, 50.0, 500.0, 1e5})
    for (int i = -1000; i <= 1000; ++i) {
      const double cosine = i / 1000.0;
      REQUIRE(reference::lobe_value(cosine, exponent) <= std::exp(exponent * (cosine - 1)) * (1 + 1e-12));
    }
}

TEST_CASE("the bound is at most 1.5 times the value where the axes agree, and falls as fast as it nearly") {
  for (const float a : {5.0f, 250.0f, 1e4f})
    for (const float b : {5.0f, 50.0f, 1e4f}) {
      const SgLight light = sg_light({vec3(0, 1, 0), a}, vec3(1));
      const SgLightBound bound(a, b);
      CHECK(double(bound.at(1, light.luminance)) < 1.501 * exact(double(a), double(b), 1));
      const float cosine = 1 - 3 * (1 / a + 1 / b);  // three times the spread away
      if (cosine > 0.5f)
        CHECK(double(bound.at(cosine, light.luminance)) < 2.5 * exact(double(a), double(b), double(cosine)));
    }
}

TEST_CASE("the least cosine is where the bound meets the threshold") {
  rc::check([] {
    Random random = any_random();
    const SgLightBound bound(std::exp(8 * random.uniform()), std::exp(8 * random.uniform()));
    const float luminance = std::exp(6 * random.uniform() - 3),
                threshold = std::exp(10 * random.uniform() - 9);
    const float cosine = bound.least_cosine(luminance, threshold);
    if (cosine > 1) {
      RC_ASSERT(bound.at(1, luminance) <= threshold * 1.0001f);
    } else if (cosine >= -1) {
      RC_ASSERT(
          close(double(bound.at(cosine, luminance)), double(threshold), 1e-5 + 4e-7 * double(bound.rate)));
    } else {
      RC_ASSERT(bound.at(-1, luminance) >= threshold * 0.9999f);
    }
  });
  CHECK(SgLightBound(0, 5).least_cosine(1e6f, 1e-3f) < -1);  // an even sky is never left out
}
