// Bases against Eigen's singular value decomposition by divide and conquer, at sizes near those in use.
#include <doctest/doctest.h>

#include "rows_for_tests.hpp"
//
#include <Eigen/SVD>

using namespace coppice;
using namespace test_support;

TEST_CASE("bases hold the singular values and vectors of Eigen's decomposition") {
  Random random(11);
  for (const auto& [count, width] : {std::pair<std::size_t, std::size_t>(150, 220), {260, 120}})
    for (const bool is_centred : {true, false}) {
      const Rows rows = rows_of_rank(random, count, width, 40, 0.85f);
      const auto data = is_centred ? centred(rows) : in_double(rows);
      Eigen::MatrixXd matrix(count, width);
      for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < width; ++k) matrix(Eigen::Index(i), Eigen::Index(k)) = data[i][k];
      const Eigen::BDCSVD<Eigen::MatrixXd> svd(matrix, Eigen::ComputeThinV);
      PcaOptions options;
      options.centred = is_centred, options.rank = 12;
      const PcaBasis basis = pca(rows, options);
      REQUIRE(basis.rank() == 12);
      for (std::size_t j = 0; j < 12; ++j) {
        const double energy = std::pow(svd.singularValues()[Eigen::Index(j)], 2);
        CHECK(std::abs(basis.energies[j] - energy) < 1e-9 * basis.total_energy);
        double product = 0;
        for (std::size_t k = 0; k < width; ++k)
          product += double(basis.vectors[j][k]) * svd.matrixV()(Eigen::Index(k), Eigen::Index(j));
        CHECK(std::abs(std::abs(product) - 1) < 1e-6);
      }
    }
}
