// The closed form of a Phong lobe's albedo against quadrature.
#include <doctest/doctest.h>

#include <coppice/lobe/phong_albedo.hpp>
#include <coppice/reference/lobe.hpp>

using namespace coppice;

namespace {

double integrated_albedo(double exponent, double cosine) {
  const glm::dvec3 mirror(-std::sqrt(1 - cosine * cosine), 0, cosine);
  double sum = 0;
  for (const auto& n : reference::sphere_nodes(mirror, 1 / std::sqrt(exponent + 1), 500, 120))
    sum += n.weight * std::max(0.0, n.direction.z) *
           reference::lobe_radiance(exponent, glm::dot(mirror, n.direction));
  return sum * (exponent + 2) / (exponent + 1);
}

/// The most by which the form is too large and too small, relative.
struct Worst {
  double above = 0, below = 0;
};
Worst worst_of(float exponent) {
  Worst worst;
  for (int i = 0; i <= 40; ++i) {
    const double cosine = i / 40.0;
    const double error =
        double(phong_albedo(exponent, float(cosine))) / integrated_albedo(exponent, cosine) - 1;
    worst.above = std::max(worst.above, error), worst.below = std::max(worst.below, -error);
  }
  return worst;
}

}  // namespace

TEST_CASE("the albedo of a Phong lobe has the stated error") {
  const auto check = [](float exponent, double above) {
    CAPTURE(exponent);
    const Worst worst = worst_of(exponent);
    CHECK(worst.above <= above);
    CHECK(worst.below <= 0.003);
  };
  check(1, 0.019), check(2, 0.011), check(5, 0.005);
  for (const float exponent : {20.0f, 100.0f, 1e3f, 1e5f}) check(exponent, 1.5e-3);
}

TEST_CASE("the albedo of a Phong lobe is 1 from straight above and rises with the viewer") {
  for (const float exponent : {1.0f, 2.0f, 7.5f, 100.0f, 1e5f}) {
    CHECK(phong_albedo(exponent, 1) == doctest::Approx(1).epsilon(1e-6));
    float last = 0;
    for (int i = 0; i <= 1000; ++i) {
      const float albedo = phong_albedo(exponent, float(i) / 1000);
      CHECK(std::isfinite(albedo));
      CHECK(albedo >= last);
      last = albedo;
    }
  }
  CHECK(phong_albedo(1, 0) == doctest::Approx(std::numbers::inv_pi).epsilon(0.003));
}
