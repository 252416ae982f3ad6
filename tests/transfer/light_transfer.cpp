// From direct to indirect light: against the solver, by stage, and at the extremes.
#include <coppice/core/simd.hpp>
//
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <coppice/reference/light_transfer.hpp>
#include <coppice/transfer/transfer_matrix.hpp>
#include <support/executors.hpp>
#include <support/generators.hpp>
#include <transfer/lit_box.hpp>

using namespace coppice;

namespace {

struct Built {
  LightBasis basis;
  Rows matrix;
};

Built build(const LitBox& room, LightBasisKind kind, std::size_t rank, bool mean = true) {
  const LightBasisOptions options{.rank = rank, .share_ranks = false};
  Built built;
  built.basis = kind == LightBasisKind::transport_aware
                    ? transport_aware_basis(room.samples, room.examples, room.probes(), Serial(), options)
                    : principal_light_basis(room.samples, room.examples, kind, Serial(), options);
  built.matrix = transfer_matrix(room.transport, room.samples, built.basis, Serial(),
                                 {.bounces = room.bounces, .batch = 7, .mean = mean});
  return built;
}

template <class Value>
LightTransfer<Value> compressed(const LitBox& room, const Built& built, std::size_t rank) {
  return compress_transfer<Value>(room.samples, built.basis, built.matrix, room.examples, Serial(),
                                  {.rank = rank});
}

template <class Value>
std::vector<vec3> indirect(const LightTransfer<Value>& transfer, std::span<const vec3> direct,
                           const vec3& intensity = vec3(1)) {
  std::vector<vec3> result(direct.size());
  indirect_irradiance(transfer, direct, Serial(), result, intensity);
  return result;
}

double relative_error(std::span<const vec3> x, std::span<const vec3> reference) {
  return std::sqrt(squared_difference(x, reference) / squared_norm(reference));
}

constexpr LightBasisKind all_kinds[] = {LightBasisKind::paper, LightBasisKind::uncentred,
                                        LightBasisKind::transport_aware};

}  // namespace

TEST_CASE("at full rank and 16 bits the transfer gives the solver's indirect light of example lights") {
  const LitBox room;
  for (const LightBasisKind kind : all_kinds) {
    const Built built = build(room, kind, 1000);
    const auto transfer = compressed<std::int16_t>(room, built, 1000);
    for (const std::size_t l : {std::size_t(0), std::size_t(40)}) {
      const std::vector<vec3> direct = as_grey(room.examples[l]);
      const auto exact = reference::solved(room.transport, room.samples, direct, room.bounces);
      CAPTURE(int(kind));
      CHECK(relative_error(indirect(transfer, direct), exact) < 5e-3);
    }
  }
}

TEST_CASE("the transfer at any rank is near to the basis' own twin, which solves what it keeps") {
  const LitBox room;
  for (const LightBasisKind kind : all_kinds)
    for (const bool mean : {true, false}) {
      const Built built = build(room, kind, 8, mean);
      const auto transfer = compressed<std::int16_t>(room, built, 60);
      const std::vector<vec3> direct = as_grey(room.unseen[2]);
      const auto twin = reference::indirect_irradiance(room.transport, room.samples, built.basis, direct,
                                                       room.bounces, vec3(1), mean);
      CAPTURE(int(kind));
      CAPTURE(mean);
      CHECK(relative_error(indirect(transfer, direct), twin) < 0.02);
    }
}

TEST_CASE("the paper's transfer without S·μ is wrong, and with it right") {
  const LitBox room;
  const std::vector<vec3> direct = as_grey(room.unseen[1]);
  const auto exact = reference::solved(room.transport, room.samples, direct, room.bounces);
  const Built with = build(room, LightBasisKind::paper, 20),
              without = build(room, LightBasisKind::paper, 20, false);
  CHECK(relative_error(indirect(compressed<std::int16_t>(room, with, 60), direct), exact) < 0.1);
  CHECK(relative_error(indirect(compressed<std::int16_t>(room, without, 60), direct), exact) > 0.4);
}

TEST_CASE("lights add up and scale: linear bases as they are, the paper's with the sum of intensities") {
  const LitBox room;
  for (const LightBasisKind kind : all_kinds) {
    const auto transfer = compressed<std::int8_t>(room, build(room, kind, 8), 12);
    const std::vector<vec3> a = as_grey(room.unseen[0]), b = as_grey(room.unseen[1]);
    const vec3 red(4, 1, 0.5f);
    std::vector<vec3> both;
    for (std::size_t i = 0; i < a.size(); ++i) both.push_back(red * a[i] + b[i]);
    const bool centred = kind == LightBasisKind::paper;
    const auto of_a = indirect(transfer, a), of_b = indirect(transfer, b);
    std::vector<vec3> sum;
    for (std::size_t i = 0; i < a.size(); ++i) sum.push_back(red * of_a[i] + of_b[i]);
    CHECK(relative_error(indirect(transfer, both, centred ? red + vec3(1) : vec3(1)), sum) < 1e-5);
    if (centred) CHECK(relative_error(indirect(transfer, both), sum) > 1e-2);
  }
}

TEST_CASE("a grey light that is tinted after projection gives what the coloured light gives") {
  const LitBox room;
  for (const LightBasisKind kind : all_kinds) {
    const auto transfer = compressed<std::int8_t>(room, build(room, kind, 6), 10);
    const vec3 colour(2, 0.25f, 1);
    std::vector<vec3> direct = as_grey(room.unseen[3]);
    for (vec3& x : direct) x *= colour;
    std::vector<float> grey(3 * transfer.coefficient_count()), coloured(grey.size());
    project(transfer, direct, Serial(), coloured, colour);
    project_grey(transfer, room.unseen[3], colour, Serial(), grey);
    double worst = 0, greatest = 0;
    for (std::size_t j = 0; j < grey.size(); ++j) {
      worst = std::max(worst, double(std::abs(grey[j] - coloured[j])));
      greatest = std::max(greatest, double(std::abs(coloured[j])));
    }
    CHECK(worst < 1e-5 * greatest);
  }
}

TEST_CASE("building and using the transfer is the same for any executor") {
  const LitBox room;
  const Built built = build(room, LightBasisKind::transport_aware, 6);
  CHECK(built.matrix.values == transfer_matrix(room.transport, room.samples, built.basis,
                                               support::TwoThreads(), {.bounces = room.bounces, .batch = 7})
                                   .values);
  const auto one = compressed<std::int8_t>(room, built, 10);
  const auto two = compress_transfer<std::int8_t>(room.samples, built.basis, built.matrix, room.examples,
                                                  support::TwoThreads(), {.rank = 10});
  CHECK(one.patterns.values == two.patterns.values);
  CHECK(one.mix[1].values == two.mix[1].values);
  const std::vector<vec3> direct = as_grey(room.unseen[0]);
  std::vector<vec3> again(direct.size());
  indirect_irradiance(two, direct, support::Backwards(1), again);
  CHECK(indirect(one, direct) == again);
}

TEST_CASE("the emission of a vector, solved, is its response field") {
  const LitBox room;
  const Built built = build(room, LightBasisKind::transport_aware, 4);
  const std::vector<float> sent = emission_field(room.samples, built.basis, 2, 1);
  for (std::size_t i = 0; i < sent.size(); ++i)
    if (i < room.samples.begin(2) || i >= room.samples.end(2)) CHECK(sent[i] == 0);
  const auto solved = reference::solved(room.transport, room.samples, as_grey(sent), room.bounces);
  CHECK(relative_error(response_field(built.matrix, 2 * 4 + 1), solved) < 1e-5);
}

TEST_CASE("fewer bits and patterns take fewer bytes, and what bytes() says is there") {
  const LitBox room;
  const Built built = build(room, LightBasisKind::uncentred, 6);
  const auto small = compressed<std::int8_t>(room, built, 5), more = compressed<std::int8_t>(room, built, 10);
  const auto wide = compressed<std::int16_t>(room, built, 5);
  CHECK(small.bytes() < more.bytes());
  CHECK(small.bytes() < wide.bytes());
  CHECK(small.pattern_count() == 5 * room.samples.cluster_count());
  CHECK(small.patterns.values.size() == 5 * room.samples.size());
  CHECK(small.bytes() >= small.patterns.values.size() + small.projection.values.size() +
                             3 * small.pattern_count() * small.coefficient_count());
}

TEST_CASE("no samples, no vectors, and black walls give no indirect light") {
  const LitBox nothing(0);
  const auto empty = compressed<std::int8_t>(nothing, build(nothing, LightBasisKind::uncentred, 5), 5);
  CHECK(indirect(empty, std::vector<vec3>{}).empty());
  LitBox room;
  const auto none = compressed<std::int8_t>(room, build(room, LightBasisKind::uncentred, 0), 5);
  for (SurfaceSample& sample : room.samples.samples) sample.colour = vec3(0);
  const auto black = compressed<std::int8_t>(room, build(room, LightBasisKind::uncentred, 5), 5);
  const std::vector<vec3> direct = as_grey(room.unseen[0]);
  CHECK(squared_norm(indirect(none, direct)) == 0);
  CHECK(squared_norm(indirect(black, direct)) == 0);
}

TEST_CASE("light that is not a number stays one on every cluster that it shines on") {
  const LitBox room;
  const auto transfer = compressed<std::int8_t>(room, build(room, LightBasisKind::uncentred, 5), 8);
  std::vector<vec3> direct = as_grey(room.unseen[0]);
  direct[10].y = std::numeric_limits<float>::quiet_NaN();
  const auto result = indirect(transfer, direct);
  for (const vec3& x : result) {
    CHECK(std::isnan(x.y));
    CHECK(std::isfinite(x.x));
  }
}
