// Bases for direct light: orthonormal or biorthogonal, complete at full rank, and refused where input is bad.
#include <coppice/core/simd.hpp>
//
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include <coppice/reference/light_transfer.hpp>
#include <coppice/transfer/transport_aware_basis.hpp>
#include <limits>
#include <support/executors.hpp>
#include <transfer/lit_box.hpp>

using namespace coppice;

namespace {

double inner(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += double(a[i]) * double(b[i]);
  return sum;
}

/// The greatest entry of projection · emissionᵀ - 1.
double worst_of_identity(const ClusterLightBasis& basis) {
  double worst = 0;
  for (std::size_t a = 0; a < basis.rank(); ++a)
    for (std::size_t b = 0; b < basis.rank(); ++b)
      worst = std::max(worst, std::abs(inner(basis.projection[a], basis.emission[b]) - (a == b ? 1 : 0)));
  return worst;
}

/// A basis of every kind.
LightBasis basis_of(const LitBox& room, LightBasisKind kind, const LightBasisOptions& options = {}) {
  return kind == LightBasisKind::transport_aware
             ? transport_aware_basis(room.samples, room.examples, room.probes(), Serial(), options)
             : principal_light_basis(room.samples, room.examples, kind, Serial(), options);
}

constexpr LightBasisKind all_kinds[] = {LightBasisKind::paper, LightBasisKind::uncentred,
                                        LightBasisKind::transport_aware};

bool equal(const LightBasis& a, const LightBasis& b) {
  if (a.clusters.size() != b.clusters.size()) return false;
  for (std::size_t c = 0; c < a.clusters.size(); ++c)
    if (a.clusters[c].projection.values != b.clusters[c].projection.values ||
        a.clusters[c].emission.values != b.clusters[c].emission.values ||
        a.clusters[c].mean != b.clusters[c].mean)
      return false;
  return true;
}

/// ‖S(x - kept x)‖ / ‖S x‖ over lights.
double loss(const LitBox& room, const LightBasis& basis, const Rows& lights) {
  double lost = 0, all = 0;
  for (std::size_t l = 0; l < lights.count(); ++l) {
    const std::vector<vec3> direct = as_grey(lights[l]);
    const auto exact = reference::solved(room.transport, room.samples, direct, room.bounces);
    const auto kept =
        reference::indirect_irradiance(room.transport, room.samples, basis, direct, room.bounces);
    lost += squared_difference(kept, exact), all += squared_norm(exact);
  }
  return std::sqrt(lost / all);
}

}  // namespace

TEST_CASE("what a basis of any kind emits for a coefficient projects to that coefficient alone") {
  const LitBox room;
  for (const LightBasisKind kind : all_kinds)
    for (const ClusterLightBasis& cluster : basis_of(room, kind, {.rank = 12}).clusters) {
      CHECK(cluster.rank() > 0);
      CHECK(worst_of_identity(cluster) < 2e-4);
    }
}

TEST_CASE("the paper's and the uncentred basis are orthonormal, and emit what they project with") {
  const LitBox room;
  for (const LightBasisKind kind : {LightBasisKind::paper, LightBasisKind::uncentred})
    for (const ClusterLightBasis& cluster : basis_of(room, kind, {.rank = 12}).clusters) {
      CHECK(cluster.projection.values == cluster.emission.values);
      CHECK(worst_of_identity(cluster) < 2e-6);
    }
}

TEST_CASE("a light's intensity is the factor of what linear bases keep, and with its intensity the paper's") {
  const LitBox room;
  const std::vector<vec3> direct = as_grey(room.unseen[0]);
  std::vector<vec3> brighter = direct;
  const vec3 factor(3, 0.5f, 7);
  for (vec3& x : brighter) x *= factor;
  for (const LightBasisKind kind : all_kinds) {
    const LightBasis basis = basis_of(room, kind, {.rank = 6});
    const auto kept = reference::kept_light(room.samples, basis, direct);
    const auto more =
        reference::kept_light(room.samples, basis, brighter, basis.centred() ? factor : vec3(1));
    double worst = 0, greatest = 0;
    for (std::size_t i = 0; i < kept.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        worst = std::max(worst, std::abs(double(more[i][c] - factor[c] * kept[i][c])));
        greatest = std::max(greatest, double(std::abs(factor[c] * kept[i][c])));
      }
    CHECK(worst < 1e-5 * greatest);
  }
}

TEST_CASE("at equal rank the basis that knows the transport loses less of unseen lights' indirect light") {
  const LitBox room;
  for (const std::size_t rank : {std::size_t(3), std::size_t(6)}) {
    const double plain = loss(room, basis_of(room, LightBasisKind::uncentred, {.rank = rank}), room.unseen);
    const double aware =
        loss(room, basis_of(room, LightBasisKind::transport_aware, {.rank = rank}), room.unseen);
    CAPTURE(rank);
    CAPTURE(plain);
    CHECK(aware < 0.9 * plain);
  }
}

TEST_CASE("of the paper's basis Eq. 10 without S·μ loses most of the light, and with it little") {
  const LitBox room;
  const LightBasis basis = basis_of(room, LightBasisKind::paper, {.rank = 20});
  const std::vector<vec3> direct = as_grey(room.unseen[1]);
  const auto exact = reference::solved(room.transport, room.samples, direct, room.bounces);
  const auto error = [&](bool mean) {
    return std::sqrt(squared_difference(reference::indirect_irradiance(room.transport, room.samples, basis,
                                                                       direct, room.bounces, vec3(1), mean),
                                        exact) /
                     squared_norm(exact));
  };
  CHECK(error(true) < 0.1);
  CHECK(error(false) > 0.4);
}

TEST_CASE("bases are the same for any executor") {
  const LitBox room;
  const LightBasisOptions options{.rank = 5};
  CHECK(equal(principal_light_basis(room.samples, room.examples, LightBasisKind::paper, Serial(), options),
              principal_light_basis(room.samples, room.examples, LightBasisKind::paper, support::TwoThreads(),
                                    options)));
  const Rows probes = room.probes();
  CHECK(probes.values ==
        transport_probes(room.transport, albedos_of(room.samples.samples), support::Backwards()).values);
  CHECK(equal(transport_aware_basis(room.samples, room.examples, probes, Serial(), options),
              transport_aware_basis(room.samples, room.examples, probes, support::TwoThreads(), options)));
}

TEST_CASE("clusters share ranks, and no more than there are in all") {
  const LitBox room;
  const LightBasis shared = basis_of(room, LightBasisKind::transport_aware, {.rank = 5});
  CHECK(shared.coefficient_count() == 5 * room.samples.cluster_count());
  for (const ClusterLightBasis& cluster : shared.clusters)
    CHECK(cluster.projection.values.size() == cluster.rank() * cluster.projection.width);
  const LightBasis equal_ranks =
      basis_of(room, LightBasisKind::transport_aware, {.rank = 5, .share_ranks = false});
  for (const ClusterLightBasis& cluster : equal_ranks.clusters) CHECK(cluster.rank() == 5);
  const LightBasis all = basis_of(room, LightBasisKind::uncentred, {.rank = 100000});
  for (std::size_t c = 0; c < all.clusters.size(); ++c)
    CHECK(all.clusters[c].rank() <= std::min(room.samples.size(c), room.examples.count()));
}

TEST_CASE(
    "no samples, no lights, one light, a cluster in the dark, and black walls give bases without harm") {
  LitBox room;
  for (const LightBasisKind kind : all_kinds) {
    CHECK(basis_of(LitBox(0), kind).coefficient_count() == 0);
    LitBox dark = room;
    for (std::size_t l = 0; l < dark.examples.count(); ++l)
      for (std::size_t i = 0; i < dark.samples.end(0); ++i) dark.examples[l][i] = 0;
    const LightBasis partly = basis_of(dark, kind);
    CHECK(partly.clusters[0].rank() == 0);
    CHECK(partly.clusters[1].rank() > 0);
    dark.examples = Rows(0, 0);
    CHECK(basis_of(dark, kind).coefficient_count() == 0);
    LitBox one = room;
    one.examples.values.resize(one.examples.width);
    const LightBasis single = basis_of(one, kind);
    if (kind == LightBasisKind::paper) CHECK(single.coefficient_count() == 0);
    if (kind == LightBasisKind::uncentred)
      for (const ClusterLightBasis& cluster : single.clusters) CHECK(cluster.rank() <= 1);
    if (kind == LightBasisKind::transport_aware) CHECK(single.coefficient_count() > 0);
  }
  for (SurfaceSample& sample : room.samples.samples) sample.colour = vec3(0);
  CHECK(basis_of(room, LightBasisKind::transport_aware).coefficient_count() == 0);
}

TEST_CASE("example lights that are not finite are refused by name") {
  LitBox room;
  room.examples[3][7] = std::numeric_limits<float>::quiet_NaN();
  for (const LightBasisKind kind : all_kinds) {
    bool named = false;
    try {
      basis_of(room, kind);
    } catch (const InputError& error) {
      named = error.item() == "example light 3";
    }
    CHECK(named);
  }
}
