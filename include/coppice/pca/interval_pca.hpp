// Principal components of rows whose entries may take any value of an interval.
#pragma once

#include <coppice/pca/basis.hpp>

namespace coppice {

struct IntervalPcaOptions {
  bool centred = true;    ///< as PcaOptions::centred
  std::size_t rank = 50;  ///< at most so many vectors
  int rounds = 5;         ///< of clamping and PCA after the first PCA, >= 0; 0 gives the PCA of the start
  std::uint64_t seed = 1;
};

/// A basis and the coefficients with which each row's reconstruction comes near to its intervals.
struct IntervalPca {
  PcaBasis basis;     ///< its energies are those of the last clamped rows
  Rows coefficients;  ///< a row for each row; reconstruct() gives the values, which may lie outside a little
  std::vector<double> violations;  ///< Σ squared distances of the reconstruction from the intervals: after
                                   ///< the PCA of the start and after each round; never growing, to rounding
};

/// Rows of the given rank that lie near to the intervals [low, high], by alternating projections (DESIGN 3d):
/// clamp the reconstruction into the intervals, then find a better basis of what that gives. The first rows
/// are `start`, by default low where it is finite, else high, else 0. Each round improves the last basis by
/// one block power step and the best vectors of the space of both, so that the violation never grows. Other
/// starts may lead elsewhere: the problem has many local minima. Cost: one pca() of PcaSolver::automatic, and
/// 8 n d rank operations a round for n rows of d. Throws InputError naming row and column where an end is
/// NaN, an interval is empty, or a start is not finite. Preconditions: low, high (and start, if any) have the
/// same size.
IntervalPca interval_pca(const Rows& low, const Rows& high, const IntervalPcaOptions& options = {},
                         const Rows& start = {});

}  // namespace coppice
