// The slow twins of lobes against what is known of them.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/reference/lobe.hpp>

using namespace coppice;
using namespace coppice::reference;
using glm::dvec3;

namespace {

constexpr double exponents[] = {0, 1, 5, 20, 100, 1e4};
constexpr double lengths[] = {0.9999, 0.99, 0.9, 0.5, 0.2, 1e-3, 0};
constexpr dvec3 axis(0.6, 0, 0.8);

/// ∫ f over the sphere, and ∫ f cosine, cosine that to the axis.
struct Moments {
  double whole = 0, along = 0;
};
template <class F>
Moments moments(double width, F f) {
  Moments m;
  for (const SphereNode& n : sphere_nodes(axis, width, 400, 4)) {
    const double cosine = std::min(1.0, glm::dot(n.direction, axis)), value = f(cosine) * n.weight;
    m.whole += value, m.along += value * cosine;
  }
  return m;
}

}  // namespace

TEST_CASE("the nodes of a quadrature cover the sphere, however narrow their middle") {
  for (const double width : {1e-3, 0.1, 1.0, 10.0}) {
    double whole = 0, square = 0;
    for (const SphereNode& n : sphere_nodes(axis, width, 200, 40)) {
      CHECK(glm::length(n.direction) == doctest::Approx(1).epsilon(1e-12));
      whole += n.weight, square += n.weight * n.direction.x * n.direction.x;
    }
    CHECK(whole == doctest::Approx(4 * std::numbers::pi).epsilon(2e-3));
    CHECK(square == doctest::Approx(4 * std::numbers::pi / 3).epsilon(2e-3));
  }
}

TEST_CASE("a lobe of radiance has energy 1 and a mean of length (k + 1)/(k + 2)") {
  for (const double k : exponents) {
    const auto [whole, along] = moments(1 / std::sqrt(k + 1), [&](double c) { return lobe_radiance(k, c); });
    CHECK(whole == doctest::Approx(1).epsilon(1e-3));
    CHECK(along == doctest::Approx((k + 1) / (k + 2)).epsilon(1e-3));
  }
  CHECK(lobe_radiance(-1, 0.5) == lobe_radiance(0, 0.5));
}

TEST_CASE("a spherical Gaussian has energy 1 and the mean length that it was asked for") {
  for (const double length : lengths) {
    const SphericalGaussian gaussian(length);
    const auto [whole, along] =
        moments(1 / std::sqrt(gaussian.sharpness() + 1), [&](double c) { return gaussian.density(c); });
    CHECK(whole == doctest::Approx(1).epsilon(1e-3));
    CHECK(std::abs(along - length) <= 1e-3);
  }
}

TEST_CASE("a lobe that is spread keeps its energy, and the lengths of the two means multiply") {
  for (const double k : exponents)
    for (const double length : lengths) {
      CAPTURE(k);
      CAPTURE(length);
      const SpreadLobe spread(k, length);
      const double sharpest = std::min(k, SphericalGaussian(length).sharpness());
      const auto [whole, along] = moments(1 / std::sqrt(sharpest + 1), spread);
      CHECK(whole == doctest::Approx(1).epsilon(1e-3));
      CHECK(std::abs(along - length * (k + 1) / (k + 2)) <= 2e-3);
    }
}

TEST_CASE("a lobe spread not at all is itself, and one spread evenly shines evenly") {
  for (const double k : exponents)
    for (const double c : {-1.0, -0.1, 0.0, 0.3, 0.99, 1.0}) {
      CHECK(SpreadLobe(k, 1)(c) == lobe_radiance(k, c));
      CHECK(SpreadLobe(k, 0)(c) == doctest::Approx(0.25 * std::numbers::inv_pi).epsilon(5e-3));
      if (std::abs(c) > 0.2 && k < 1000)
        CHECK(SpreadLobe(k, 1 - 1e-7)(c) == doctest::Approx(lobe_radiance(k, c)).epsilon(2e-3).scale(1e-6));
    }
}

TEST_CASE("many lobes about an axis shine as one lobe spread like them") {
  const SphericalGaussian gaussian(0.8);
  for (const double k : {1.0, 20.0, 100.0}) {
    std::vector<Lobe> lobes;
    for (const SphereNode& n : sphere_nodes(axis, 0.5, 120, 60))
      lobes.push_back({n.direction, k, n.weight * gaussian.density(glm::dot(n.direction, axis))});
    const SpreadLobe spread(k, 0.8);
    for (const double angle : {0.0, 0.3, 0.8, 1.5, 2.5}) {
      const dvec3 towards = axis * std::cos(angle) + dvec3(0, 1, 0) * std::sin(angle);
      CHECK(radiance(lobes, towards) == doctest::Approx(spread(std::cos(angle))).epsilon(3e-3));
    }
    CHECK(glm::length(mean_direction(lobes) - 0.8 * (k + 1) / (k + 2) * axis) <= 1e-3);
  }
}

TEST_CASE("the mean direction of lobes is that of the light they give") {
  Random random(1);
  std::vector<Lobe> lobes;
  for (int i = 0; i < 20; ++i)
    lobes.push_back({glm::normalize(dvec3(random.direction())), 30.0 * double(random.uniform()),
                     double(random.uniform())});
  dvec3 sum(0);
  double energy = 0;
  for (const SphereNode& n : sphere_nodes(axis, 3, 200, 200)) {
    const double l = n.weight * radiance(lobes, n.direction);
    sum += l * n.direction, energy += l;
  }
  CHECK(glm::length(sum / energy - mean_direction(lobes)) <= 1e-3);
}
