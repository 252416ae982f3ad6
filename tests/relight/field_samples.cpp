// Where samples of shadow fields stand, and how points between them are interpolated.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/relight/field_samples.hpp>
#include <functional>

using namespace coppice;

namespace {

using Function = std::function<double(const vec3&)>;

double interpolate(const FieldSamples& samples, const std::vector<vec3>& positions, const vec3& point,
                   const Function& f) {
  const SampleBlend blend = locate(samples, point);
  double sum = 0;
  for (std::uint32_t i = 0; i < blend.count; ++i)
    sum += double(blend.weights[i]) * f(positions[blend.samples[i]]);
  return sum;
}

double sum_of_weights(const SampleBlend& blend) {
  double sum = 0;
  for (std::uint32_t i = 0; i < blend.count; ++i) sum += double(blend.weights[i]);
  return sum;
}

/// All samples of a blend are those of one place, but for rounding.
bool is_at(const SampleBlend& blend, const std::vector<vec3>& positions, const vec3& place, float size) {
  double off = 0;
  for (std::uint32_t i = 0; i < blend.count; ++i)
    off += double(blend.weights[i] * length(positions[blend.samples[i]] - place));
  return blend.count > 0 && off < 1e-5 * double(size);
}

/// In double: the octahedral map of a direction, the lower half folded outward.
glm::dvec2 octahedral(const glm::dvec3& d) {
  const double sum = std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z);
  const glm::dvec2 p = glm::dvec2(d) / sum;
  if (d.z >= 0) return p;
  return {std::copysign(1 - std::fabs(p.y), p.x), std::copysign(1 - std::fabs(p.x), p.y)};
}

vec3 random_point_in_shells(Random& random, const vec3& centre) {
  return centre + std::exp2(4 * random.uniform()) * random.direction();
}

const vec3 centre(1, 2, 3);
const std::array<int, 4> resolutions{1, 2, 7, 24};

}  // namespace

TEST_CASE("shells stand on spheres around the centre, at radii that grow by a constant factor") {
  const ShellSamples shells(centre, 0.5f, 7, 2, 4);
  const auto positions = shells.positions();
  REQUIRE(positions.size() == shells.count());
  REQUIRE(shells.count() == 9 * 25);
  for (std::size_t s = 0; s < 9; ++s)
    for (std::size_t i = 0; i < 25; ++i)
      CHECK(length(positions[25 * s + i] - centre) == doctest::Approx(0.5 * std::exp2(0.5 * double(s))));
  CHECK(length(positions.back() - centre) >= 7);
}

TEST_CASE("every sample is located at itself") {
  for (const int resolution : resolutions) {
    const ShellSamples shells(centre, 1, 8, 3, resolution);
    const auto positions = shells.positions();
    for (const vec3& p : positions)
      if (length(p - centre) <= 8) CHECK(is_at(shells.locate(p), positions, p, 8));
  }
  const GridSamples grid(vec3(-1, 0, 2), vec3(1, 0, 2.5f), 0.3f);
  const auto positions = grid.positions();
  REQUIRE(positions.size() == grid.count());
  CHECK(grid.count() == 8 * 1 * 3);
  for (const vec3& p : positions) CHECK(is_at(grid.locate(p), positions, p, 1));
}

TEST_CASE("weights are positive and sum to 1, of samples that exist") {
  Random random(1);
  for (const int resolution : resolutions) {
    const FieldSamples all[] = {ShellSamples(centre, 1, 16, 3, resolution),
                                GridSamples(centre - 4.0f, centre + vec3(1, 2, 3), 0.7f)};
    for (const FieldSamples& samples : all)
      for (int i = 0; i < 500; ++i) {
        const SampleBlend blend = locate(samples, random_point_in_shells(random, centre));
        if (blend.count == 0) continue;
        CHECK(sum_of_weights(blend) == doctest::Approx(1));
        for (std::uint32_t k = 0; k < blend.count; ++k) {
          CHECK(blend.weights[k] > 0);
          CHECK(blend.samples[k] < positions_of(samples).size());
        }
      }
  }
}

TEST_CASE("between shells, what is linear in the logarithm of the distance is exact") {
  Random random(2);
  const FieldSamples shells = ShellSamples(centre, 1, 16, 3, 6);
  const auto positions = positions_of(shells);
  const Function logarithm = [](const vec3& p) { return std::log2(double(length(p - centre))); };
  for (int i = 0; i < 500; ++i) {
    const vec3 p = random_point_in_shells(random, centre);
    if (length(p - centre) > 16) continue;
    CHECK(interpolate(shells, positions, p, logarithm) == doctest::Approx(logarithm(p)).epsilon(1e-5));
  }
}

TEST_CASE("between directions, what is linear in the map is exact, off the fold") {
  Random random(3);
  const FieldSamples shells = ShellSamples(centre, 1, 16, 2, 8);
  const auto positions = positions_of(shells);
  int tested = 0;
  for (int i = 0; i < 1000; ++i) {
    const vec3 p = random_point_in_shells(random, centre);
    const glm::dvec2 at = octahedral(glm::dvec3(p - centre));
    if (length(p - centre) > 16 || at.x < 0 || at.y < 0 || at.x + at.y > 1) continue;
    const glm::dvec2 cell = glm::floor(at * 4.0);
    if (cell.x + cell.y + 2 > 4) continue;  // its corners lie on both sides of the fold, or beyond it
    const Function map = [](const vec3& q) {
      const glm::dvec2 m = octahedral(glm::dvec3(q - centre));
      return 3 * m.x - 2 * m.y + 1;
    };
    CHECK(std::abs(interpolate(shells, positions, p, map) - map(p)) < 1e-5);
    ++tested;
  }
  CHECK(tested > 50);
}

TEST_CASE("a grid interpolates linear functions of space, and clamps beyond its box") {
  Random random(4);
  const vec3 low(-1, 0, 2), high(2, 0.5f, 5);
  const FieldSamples grid = GridSamples(low, high, 0.4f);
  const auto positions = positions_of(grid);
  const Function f = [](const vec3& p) { return 1 + 2 * double(p.x) - 3 * double(p.y) + 0.5 * double(p.z); };
  for (int i = 0; i < 500; ++i) {
    const vec3 p(-2 + 5 * random.uniform(), -1 + 2 * random.uniform(), 1 + 6 * random.uniform());
    CHECK(interpolate(grid, positions, p, f) ==
          doctest::Approx(f(glm::clamp(p, low, high))).epsilon(1e-4).scale(10));
  }
  const GridSamples point(low, low, 1);
  CHECK(point.count() == 1);
  CHECK(point.locate(high).count == 1);
}

TEST_CASE("small steps change what is interpolated by little: over cells, shells and the map's seams") {
  Random random(5);
  for (const int resolution : resolutions) {
    const FieldSamples shells = ShellSamples(vec3(0), 1, 16, 3, resolution);
    const auto positions = positions_of(shells);
    const Function rough = [](const vec3& p) {
      return std::sin(5 * double(p.x)) + std::cos(7 * double(p.y)) + std::sin(4 * double(p.z));
    };
    for (int i = 0; i < 1000; ++i) {
      vec3 p = random_point_in_shells(random, vec3(0));
      const int kind = i % 4;  // on a plane where cells or halves of the map meet
      if (kind < 3) p[kind] = 0;
      if (length(p) > 15.9f || length(p) < 0.1f) continue;
      const vec3 step = 1e-5f * length(p) * random.direction();
      const double change =
          interpolate(shells, positions, p + step, rough) - interpolate(shells, positions, p - step, rough);
      CHECK(std::abs(change) < 1e-5 * 6 * (12 + 8 * resolution));
    }
  }
}

TEST_CASE("nothing is found beyond the reach; inside the innermost shell its samples are") {
  const ShellSamples shells(centre, 1, 8, 3, 6);
  const auto positions = shells.positions();
  CHECK(shells.locate(centre + vec3(8.01f, 0, 0)).count == 0);
  CHECK(shells.locate(centre + vec3(7.99f, 0, 0)).count > 0);
  CHECK(shells.locate(vec3(std::numeric_limits<float>::quiet_NaN())).count == 0);
  CHECK(shells.locate(vec3(std::numeric_limits<float>::infinity())).count == 0);
  for (const float radius : {0.0f, 1e-30f, 0.3f}) {
    const SampleBlend blend = shells.locate(centre + radius * vec3(0, 0.6f, -0.8f));
    REQUIRE(blend.count > 0);
    CHECK(sum_of_weights(blend) == doctest::Approx(1));
    for (std::uint32_t i = 0; i < blend.count; ++i)
      CHECK(length(positions[blend.samples[i]] - centre) == doctest::Approx(1));
  }
}
