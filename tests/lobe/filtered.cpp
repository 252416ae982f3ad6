// What one lobe in place of many costs: filtered lobes against convolutions by quadrature. With
// COPPICE_TABLES=1 in the environment the tables of docs/lobe.md are printed.
#include <coppice/shared/lobe.h>
#include <doctest/doctest.h>

#include <array>
#include <coppice/reference/lobe.hpp>

#include "lobe/tables.hpp"

using namespace coppice;
using namespace coppice::reference;

namespace {

constexpr double exponents[] = {1, 5, 20, 60, 100, 500, 1e4};
constexpr double lengths[] = {1, 0.999, 0.99, 0.9, 0.7, 0.5, 0.2, 0};

/// Filtering Eq. 3 and 4.
double widened(double exponent, double length) {
  return double(lobe_widened(float(exponent), lobe_variance(float(1 - length))));
}

/// What lobe_sum comes to: the lengths of the means multiply.
double matched(double exponent, double length) {
  const double shortfall = 1 / (exponent + 2);
  return double(lobe_exponent(float(shortfall + (1 - length) * (1 - shortfall))));
}

/// The same, shining as lobe_shining says.
double shining(double exponent, double length) {
  return double(lobe_shining(float(matched(exponent, length))));
}

struct Errors {
  double mean = 0;    ///< ∫ |a - b| / ∫ a
  double square = 0;  ///< √(∫ (a - b)² / ∫ a²)
};

/// Of a lobe of this exponent in place of the convolution.
Errors errors_of(double exponent, const SpreadLobe& exact) {
  double apart = 0, squares = 0, whole = 0, whole_squares = 0;
  const double width = 1 / std::sqrt(std::max(exponent, 0.0) + 1);
  for (const SphereNode& n : sphere_nodes({0, 0, 1}, width, 300, 1)) {
    const double a = exact(n.direction.z), d = a - lobe_radiance(exponent, n.direction.z);
    apart += n.weight * std::abs(d), whole += n.weight * a;
    squares += n.weight * d * d, whole_squares += n.weight * a * a;
  }
  return {apart / whole, std::sqrt(squares / whole_squares)};
}

using Row = std::array<Errors, std::size(lengths)>;

Row row_of(double exponent, double (*filter)(double, double)) {
  Row row;
  for (std::size_t i = 0; i < row.size(); ++i)
    row[i] = errors_of(filter(exponent, lengths[i]), SpreadLobe(exponent, lengths[i]));
  return row;
}

using Rows = std::array<Row, std::size(exponents)>;

Rows rows_of(double (*filter)(double, double)) {
  Rows rows;
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = row_of(exponents[i], filter);
  return rows;
}

const Rows& widened_rows() {
  static const Rows rows = rows_of(&widened);
  return rows;
}
const Rows& matched_rows() {
  static const Rows rows = rows_of(&matched);
  return rows;
}
const Rows& shining_rows() {
  static const Rows rows = rows_of(&shining);
  return rows;
}

void print(const char* title, const Rows& rows) {
  lobe_test::Table table(title, "exponent", lengths);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    table.start_row(exponents[i]);
    for (const Errors& e : rows[i]) table.add({e.mean, e.square});
  }
  table.print();
}

using Limits = std::array<double, std::size(lengths)>;

/// The rows from exponent 5 on, and that of exponent 1, stay below their limits and above 0.
void check(const Rows& rows, const Limits& first, const Limits& others) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < std::size(lengths); ++j) {
      CAPTURE(exponents[i]);
      CAPTURE(lengths[j]);
      CHECK(rows[i][j].mean <= (i == 0 ? first : others)[j]);
      CHECK(rows[i][j].square <= (i == 0 ? first : others)[j]);
      if (lengths[j] < 1) CHECK(rows[i][j].mean > 1e-5);
    }
}

}  // namespace

TEST_CASE("a lobe widened by the variance of its directions comes as near to their convolution as stated") {
  print("Eq. 4: ∫|a - b| / L2, by the length of the mean", widened_rows());
  check(widened_rows(), {1e-4, 4e-3, 0.022, 0.15, 0.38, 0.57, 0.85, 1.05},
        {1e-4, 3e-3, 0.018, 0.13, 0.31, 0.48, 0.8, 1.05});
}

TEST_CASE("a lobe with the mean of the convolution comes as near to it as stated") {
  print("lobe_sum: ∫|a - b| / L2, by the length of the mean", matched_rows());
  check(matched_rows(), {1e-4, 5e-3, 0.03, 0.22, 0.48, 0.56, 0.85, 1.05},
        {1e-4, 2e-3, 0.016, 0.12, 0.36, 0.58, 0.8, 1.05});
}

TEST_CASE("wide lobes shine nearer to the convolution by lobe_shining") {
  print("lobe_shining: ∫|a - b| / L2, by the length of the mean", shining_rows());
  check(shining_rows(), {1e-4, 4e-3, 0.022, 0.15, 0.35, 0.56, 0.85, 1.05},
        {1e-4, 2e-3, 0.016, 0.12, 0.3, 0.43, 0.8, 1.05});
  for (std::size_t i = 0; i < std::size(exponents); ++i)
    for (std::size_t j = 0; j < std::size(lengths); ++j)
      CHECK(shining_rows()[i][j].mean <= matched_rows()[i][j].mean + 0.01);
  CHECK(lobe_shining(-1.0f) == 0);
  CHECK(lobe_shining(1.0f) == 1);
  CHECK(lobe_shining(50.0f) == 50);
}

TEST_CASE("lobes of different widths filtered as one keep energy and mean where Eq. 4 does not") {
  // Half the energy in a wide lobe, half in a narrow one at an angle: the mean exponent is not theirs.
  const std::vector<Lobe> lobes{{{0, 0, 1}, 4, 1}, {glm::normalize(glm::dvec3(0.5, 0, 1)), 200, 1}};
  const auto shape = [](const Lobe& l) { return LobeShape{vec3(l.direction), float(l.exponent)}; };
  const LobeShape sum = lobe_sum(shape(lobes[0]), 0.5f, shape(lobes[1]), 0.5f);
  const glm::dvec3 mean = mean_direction(lobes);
  const double k = double(sum.exponent);
  CHECK((k + 1) / (k + 2) == doctest::Approx(glm::length(mean)).epsilon(1e-6));
  const double directions = glm::length(lobes[0].direction + lobes[1].direction) / 2;
  const double paper = widened(102, directions);
  CHECK((paper + 1) / (paper + 2) > glm::length(mean) + 0.02);
}
