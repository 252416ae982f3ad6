// Lattices of light positions: which points count, and how a light is interpolated between them.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <coppice/transfer/light_lattice.hpp>

#include "support/generators.hpp"
#include "support/occluders.hpp"
#include "support/scenes.hpp"

using namespace coppice;

namespace {

const support::SphereOccluder nothing{};

std::vector<vec3> positions_in(const vec3& low, const vec3& high, std::size_t count, std::uint64_t seed = 1) {
  Random random(seed);
  std::vector<vec3> positions;
  for (std::size_t i = 0; i < count; ++i) {
    const float x = random.uniform(), y = random.uniform(), z = random.uniform();
    positions.push_back(low + vec3(x, y, z) * (high - low));
  }
  return positions;
}

float sum_of(const LatticeCorners& corners) {
  float sum = 0;
  for (std::uint32_t c = 0; c < corners.count; ++c) sum += corners.weights[c];
  return sum;
}

}  // namespace

TEST_CASE("no free positions make an empty lattice, which serves no light") {
  const LightLattice lattice = light_lattice(std::span<const vec3>(), 0.3f, nothing);
  CHECK(lattice.count() == 0);
  CHECK(lattice_corners(lattice, vec3(0), nothing).count == 0);
  CHECK(light_lattice_within(std::span<const vec3>(), 100, nothing).count() == 0);
}

TEST_CASE("one free position makes one cell of eight points") {
  const std::vector<vec3> one{vec3(1, 2, 3)};
  const LightLattice lattice = light_lattice(std::span<const vec3>(one), 0.5f, nothing);
  CHECK(lattice.count() == 8);
  const LatticeCorners corners = lattice_corners(lattice, one[0], nothing);
  CHECK(corners.count == 8);
  for (std::uint32_t c = 0; c < 8; ++c) CHECK(corners.weights[c] == doctest::Approx(0.125));
}

TEST_CASE("in the open, weights are those of trilinear interpolation") {
  const auto free = positions_in(vec3(-1), vec3(1), 4000);
  const LightLattice lattice = light_lattice(std::span<const vec3>(free), 0.4f, nothing);
  CHECK(lattice.count() == 216);
  rc::check([&] {
    Random random = test_support::any_random();
    const vec3 p = 0.99f * vec3(2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1);
    const LatticeCorners corners = lattice_corners(lattice, p, nothing);
    vec3 mean(0);
    for (std::uint32_t c = 0; c < corners.count; ++c)
      mean += corners.weights[c] * lattice.positions[corners.points[c]];
    RC_ASSERT(length(mean - p) < 1e-5f);
    RC_ASSERT(std::abs(sum_of(corners) - 1) < 1e-5f);
  });
}

TEST_CASE("a light on a lattice point takes that point alone") {
  const auto free = positions_in(vec3(-1), vec3(1), 1000);
  const LightLattice lattice = light_lattice(std::span<const vec3>(free), 0.5f, nothing);
  for (std::uint32_t i = 0; i < lattice.count(); ++i) {
    const LatticeCorners corners = lattice_corners(lattice, lattice.positions[i], nothing);
    std::uint32_t heaviest = 0;
    for (std::uint32_t c = 0; c < corners.count; ++c)
      if (corners.weights[c] > corners.weights[heaviest]) heaviest = c;
    CHECK(corners.points[heaviest] == i);
    CHECK(corners.weights[heaviest] > 0.99999f);
  }
}

TEST_CASE("points inside a solid do not count") {
  Mesh mesh;
  support::add_box(mesh, vec3(-0.7f), vec3(0.7f));
  const support::TriangleTracer tracer(mesh);
  auto free = positions_in(vec3(-2), vec3(2), 8000);
  std::erase_if(free, [](const vec3& p) { return glm::all(glm::lessThan(glm::abs(p), vec3(0.7f))); });
  const LightLattice lattice = light_lattice(std::span<const vec3>(free), 0.31f, tracer);
  CHECK(lattice.count() > 1000);
  for (const vec3& p : lattice.positions) CHECK(!glm::all(glm::lessThan(glm::abs(p), vec3(0.69f))));
}

TEST_CASE("a light beside a thin wall takes no point of the other room") {
  Mesh mesh;
  support::add_quad(mesh, vec3(0.05f, -3, -3), vec3(0, 6, 0), vec3(0, 0, 6));
  const support::TriangleTracer tracer(mesh);
  const auto free = positions_in(vec3(-1), vec3(1), 5000);
  const LightLattice lattice = light_lattice(std::span<const vec3>(free), 0.3f, tracer);
  std::size_t served = 0;
  for (const vec3& p : positions_in(vec3(-0.5f), vec3(0.5f), 500, 2)) {
    const LatticeCorners corners = lattice_corners(lattice, p, tracer);
    served += corners.count > 0;
    for (std::uint32_t c = 0; c < corners.count; ++c)
      CHECK((lattice.positions[corners.points[c]].x < 0.05f) == (p.x < 0.05f));
  }
  CHECK(served == 500);
}

TEST_CASE("a light a little outside takes the nearest points, one far away or not a number none") {
  const std::vector<vec3> one{vec3(0)};
  const LightLattice lattice = light_lattice(std::span<const vec3>(one), 1, nothing);
  const LatticeCorners beside = lattice_corners(lattice, vec3(1.2f, 0.3f, 0), nothing);
  CHECK(beside.count == 4);
  CHECK(sum_of(beside) == doctest::Approx(1));
  for (std::uint32_t c = 0; c < beside.count; ++c) CHECK(lattice.positions[beside.points[c]].x == 0.5f);
  CHECK(lattice_corners(lattice, vec3(9, 0, 0), nothing).count == 0);
  CHECK(lattice_corners(lattice, vec3(1e30f), nothing).count == 0);
  CHECK(lattice_corners(lattice, vec3(std::nanf("")), nothing).count == 0);
}

TEST_CASE("a lattice within a number of points comes near it from below") {
  const auto free = positions_in(vec3(0), vec3(9, 2, 5), 100000);
  for (const std::size_t most : {60u, 500u, 3000u}) {
    const std::size_t count = light_lattice_within(std::span<const vec3>(free), most, nothing).count();
    CHECK(count <= most);
    CHECK(count >= most / 2);
  }
}
