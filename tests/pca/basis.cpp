// Bases of principal components against one-sided Jacobi rotations, and at the extremes of data.
#include <doctest/doctest.h>
#include <rapidcheck.h>

#include "rows_for_tests.hpp"
//
#include <coppice/core/error.hpp>
#include <limits>

#include "support/generators.hpp"

using namespace coppice;
using namespace test_support;

namespace {

constexpr PcaSolver all_solvers[] = {PcaSolver::automatic, PcaSolver::gram, PcaSolver::covariance,
                                     PcaSolver::subspace};

/// Energies, vectors and mean against the twin, for vectors with more than `share` of the energy.
void check_against_twin(const PcaBasis& basis, const Rows& rows, bool is_centred, double share) {
  const auto data = is_centred ? centred(rows) : in_double(rows);
  const auto twin = reference::singular_vectors(data);
  for (std::size_t j = 0; j < basis.rank(); ++j) {
    const double energy = twin.values[j] * twin.values[j];
    REQUIRE(std::abs(basis.energies[j] - energy) <= 1e-9 * basis.total_energy);
    if (energy < share * basis.total_energy) continue;
    const std::vector<double> vector(basis.vectors[j].begin(), basis.vectors[j].end());
    REQUIRE(std::abs(std::abs(reference::dot(vector, twin.vectors[j])) - 1) < 1e-6);
  }
}

}  // namespace

TEST_CASE("every solver finds the energies and vectors that Jacobi rotations find") {
  Random random(1);
  for (const auto& [count, width] :
       {std::pair<std::size_t, std::size_t>(30, 45), {45, 30}, {80, 12}, {12, 80}})
    for (const bool is_centred : {true, false})
      for (const PcaSolver solver : all_solvers) {
        const Rows rows = rows_of_rank(random, count, width, 9);
        PcaOptions options;
        options.centred = is_centred, options.solver = solver;
        const PcaBasis basis = pca(rows, options);
        REQUIRE(basis.rank() == 9);
        REQUIRE(basis.loss() < 1e-12);
        check_against_twin(basis, rows, is_centred, 1e-4);
      }
}

TEST_CASE("the subspace solver finds what the full solvers find where it does not fall back on them") {
  Random random(2);
  for (const auto& [count, width] : {std::pair<std::size_t, std::size_t>(150, 300), {300, 150}}) {
    const Rows rows = rows_of_rank(random, count, width, 60, 0.9f);
    PcaOptions options;
    options.rank = 8, options.solver = PcaSolver::subspace;
    const PcaBasis basis = pca(rows, options);
    options.solver = count < width ? PcaSolver::gram : PcaSolver::covariance;
    const PcaBasis full = pca(rows, options);
    REQUIRE(basis.rank() == 8);
    for (std::size_t j = 0; j < 8; ++j) {
      CHECK(std::abs(basis.energies[j] - full.energies[j]) < 1e-10 * full.total_energy);
      CHECK(std::abs(dot(basis.vectors[j], full.vectors[j]) - 1) < 1e-5f);
    }
    CHECK(std::abs(basis.loss() - full.loss()) < 1e-9);
  }
}

TEST_CASE("bases of any data are orthonormal to 1e-6, and each vector's largest entry is positive") {
  rc::check([] {
    Random random = any_random();
    const auto count = *rc::gen::inRange<std::size_t>(1, 40), width = *rc::gen::inRange<std::size_t>(1, 40);
    const auto rank = *rc::gen::inRange<std::size_t>(1, 40);
    const float decay = *rc::gen::element(1.0f, 0.5f, 0.03f);
    PcaOptions options;
    options.solver = *rc::gen::elementOf(std::vector(std::begin(all_solvers), std::end(all_solvers)));
    options.rank = *rc::gen::inRange<std::size_t>(0, 50);
    options.centred = *rc::gen::arbitrary<bool>();
    const Rows rows = rows_of_rank(random, count, width, rank, decay);
    const PcaBasis basis = pca(rows, options);
    RC_ASSERT(basis.rank() <= std::min({count, width, rank, options.rank}));
    RC_ASSERT(basis.vectors.width == width && basis.vectors.count() == basis.rank());
    RC_ASSERT(orthonormality_error(basis.vectors) < 1e-6);
    for (std::size_t j = 0; j < basis.rank(); ++j) {
      const auto v = basis.vectors[j];
      RC_ASSERT(*std::ranges::max_element(v) >= -*std::ranges::min_element(v));
      if (j > 0) RC_ASSERT(basis.energies[j] <= basis.energies[j - 1]);
    }
  });
}

TEST_CASE("the squared error of reconstructions is the energy that the basis leaves out") {
  Random random(3);
  const Rows rows = rows_of_rank(random, 50, 70, 30, 0.9f);
  for (const std::size_t rank : {0, 1, 5, 20}) {
    PcaOptions options;
    options.rank = rank;
    const PcaBasis basis = pca(rows, options);
    const Rows again = reconstruct(basis, project(basis, rows), rows.count());
    CHECK(close(squared_error(rows, again), basis.loss() * basis.total_energy, 1e-5));
  }
}

TEST_CASE("a row, many rows and a single entry are reconstructed alike") {
  Random random(4);
  const Rows rows = rows_of_rank(random, 20, 37, 6);
  const PcaBasis basis = pca(rows);
  const Rows coefficients = project(basis, rows), again = reconstruct(basis, coefficients, 20);
  std::vector<float> row(37), one(basis.rank());
  for (std::size_t i = 0; i < 20; ++i) {
    project(basis, rows[i], one);
    CHECK(std::ranges::equal(one, coefficients[i]));
    reconstruct(basis, one, row);
    CHECK(std::ranges::equal(row, again[i]));
    for (std::size_t k = 0; k < 37; ++k) {
      CHECK(std::abs(reconstruct_entry(basis, one, k) - row[k]) < 2e-6f);
      CHECK(std::abs(row[k] - rows[i][k]) < 1e-5f);
    }
  }
}

TEST_CASE("dot keeps its error bound for every length") {
  Random random(9);
  for (std::size_t n = 0; n < 300; ++n) {
    const Rows rows = random_rows(random, 2, 300);
    double exact = 0, magnitude = 0;
    for (std::size_t k = 0; k < n; ++k) {
      exact += double(rows[0][k]) * double(rows[1][k]);
      magnitude += std::abs(double(rows[0][k]) * double(rows[1][k]));
    }
    const double found = dot(rows[0].first(n), rows[1].first(n));
    REQUIRE(std::abs(found - exact) <= (double(n) / 16 + 24) * 6e-8 * magnitude);
  }
}

TEST_CASE("the rank is the least whose loss is at most the loss that was asked for") {
  Random random(5);
  const Rows rows = rows_of_rank(random, 60, 40, 25, 0.8f);
  for (const PcaSolver solver : all_solvers)
    for (const double loss : {0.5, 0.1, 0.01, 1e-4}) {
      PcaOptions options;
      options.loss = loss, options.solver = solver;
      const PcaBasis basis = pca(rows, options);
      CHECK(basis.loss() <= loss);
      REQUIRE(basis.rank() > 0);
      CHECK(basis.loss() + basis.energies.back() / basis.total_energy > loss);
    }
  PcaOptions options;
  options.loss = 1;
  CHECK(pca(rows, options).rank() == 0);
}

TEST_CASE("a row with weight 3 counts as three rows, and one with weight 0 not at all") {
  Random random(6);
  const Rows rows = random_rows(random, 12, 9);
  Rows repeated(0, 9);
  PcaOptions weighted;
  for (std::size_t i = 0; i < 12; ++i) {
    weighted.weights.push_back(float(i % 4));
    for (std::size_t n = 0; n < i % 4; ++n)
      repeated.values.insert(repeated.values.end(), rows[i].begin(), rows[i].end());
  }
  const PcaBasis a = pca(rows, weighted), b = pca(repeated);
  REQUIRE(a.rank() == b.rank());
  for (std::size_t k = 0; k < 9; ++k) CHECK(std::abs(a.mean[k] - b.mean[k]) < 1e-7f);
  for (std::size_t j = 0; j < a.rank(); ++j) CHECK(close(a.energies[j], b.energies[j], 1e-6));
}

TEST_CASE("scaling the data scales the energies, from 1e-30 to 1e30") {
  for (const float scale : {1e-38f, 1e-30f, 1.0f, 1e30f, 1e37f})
    for (const PcaSolver solver : all_solvers) {
      Random random(7);
      const Rows rows = random_rows(random, 40, 60, scale);
      PcaOptions options;
      options.rank = 3, options.solver = solver;
      const PcaBasis basis = pca(rows, options);
      REQUIRE(basis.rank() == 3);
      CHECK(orthonormality_error(basis.vectors) < 1e-6);
      check_against_twin(basis, rows, true, 2);  // energies alone: those of noise lie close together
    }
}

TEST_CASE("constant rows give an empty basis when centred, and one vector when not") {
  Rows rows(17, 23);
  for (std::size_t i = 0; i < rows.values.size(); ++i) rows.values[i] = 0.1f * float(i % 23) + 1;
  PcaOptions options;
  options.weights.assign(17, 0.3f);
  for (const PcaSolver solver : all_solvers) {
    options.solver = solver, options.centred = true;
    const PcaBasis empty = pca(rows, options);
    CHECK(empty.rank() == 0);
    CHECK(empty.loss() == 0);
    const Rows again = reconstruct(empty, project(empty, rows), 17);
    CHECK(again.values == rows.values);
    options.centred = false;
    CHECK(pca(rows, options).rank() == 1);
  }
}

TEST_CASE("no rows, no columns, a single row, a single column and zeros are data too") {
  for (const PcaSolver solver : all_solvers) {
    PcaOptions options;
    options.solver = solver;
    CHECK(pca(Rows(), options).width() == 0);
    const PcaBasis none = pca(Rows(0, 5), options);
    CHECK((none.width() == 5 && none.rank() == 0 && none.vectors.width == 5));
    CHECK(pca(Rows(8, 5), options).rank() == 0);
    Rows row(1, 4);
    row.values = {3, 0, -4, 0};
    CHECK(pca(row, options).rank() == 0);
    options.centred = false;
    const PcaBasis one = pca(row, options);
    REQUIRE(one.rank() == 1);
    CHECK(std::abs(one.vectors[0][2] - 0.8f) < 1e-7f);
    Rows column(4, 1);
    column.values = {1, 2, 3, 4};
    REQUIRE(pca(column, options).rank() == 1);
    CHECK(close(pca(column, options).energies[0], 30, 1e-12));
  }
}

TEST_CASE("values that are not finite are refused by row and column") {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    Rows rows(4, 3);
    rows[2][1] = bad;
    CHECK_THROWS_WITH_AS(pca(rows), doctest::Contains("row 2, column 1"), InputError);
  }
}

TEST_CASE("the same data gives the same basis bit by bit") {
  Random random(8);
  const Rows rows = rows_of_rank(random, 120, 200, 40, 0.9f);
  PcaOptions options;
  options.rank = 6;
  const PcaBasis a = pca(rows, options), b = pca(rows, options);
  CHECK(a.vectors.values == b.vectors.values);
  CHECK(a.energies == b.energies);
}
