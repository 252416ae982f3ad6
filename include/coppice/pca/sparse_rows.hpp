// A matrix of which only the largest entries are kept: the paper's sparse form (PCA section 4.4).
#pragma once

#include <coppice/pca/quantised_rows.hpp>
#include <numeric>

namespace coppice {

/// How an entry of SparseRows is stored.
template <class Value>
concept SparseEntry = QuantisedEntry<Value> || std::same_as<Value, float>;

/// Row i holds the entries [begin(i), begin(i + 1)): scales[i] · values[e] in column columns[e], and zeros
/// elsewhere. Columns ascend within a row.
template <SparseEntry Value>
struct SparseRows {
  std::size_t width = 0;
  std::vector<std::uint32_t> begins;  ///< one more than rows
  std::vector<std::uint16_t> columns;
  std::vector<Value> values;
  std::vector<float> scales;  ///< a row: its step; 1 for floats

  std::size_t count() const { return scales.size(); }
  std::size_t begin(std::size_t i) const { return begins[i]; }
  /// Bytes of all that is stored; scales count only where they say something.
  std::size_t bytes() const {
    const std::size_t scale_bytes = std::same_as<Value, float> ? 0 : scales.size() * sizeof(float);
    return begins.size() * sizeof(std::uint32_t) + columns.size() * sizeof(std::uint16_t) +
           values.size() * sizeof(Value) + scale_bytes;
  }
};

namespace detail {

/// Whether each entry is among the `kept` of the largest magnitudes; of equals the first are. Zeros never.
inline std::vector<bool> largest_entries(const Rows& rows, std::size_t kept) {
  std::vector<bool> chosen(rows.values.size(), false);
  std::vector<std::size_t> order(rows.values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto larger = [&](std::size_t a, std::size_t b) {
    const float x = std::abs(rows.values[a]), y = std::abs(rows.values[b]);
    return x > y || (x == y && a < b);
  };
  if (kept < order.size())
    std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(kept), order.end(), larger);
  for (std::size_t i = 0; i < kept; ++i) chosen[order[i]] = rows.values[order[i]] != 0;
  return chosen;
}

}  // namespace detail

/// The `share` of the entries that are largest over all rows together, rounded to their nearest number; each
/// comes back within 0.503 steps of its row, floats exactly. Cost: one selection over all entries.
/// Preconditions: finite values; 0 <= share <= 1; at most 65,536 columns and 2^32 - 1 kept entries.
template <SparseEntry Value>
SparseRows<Value> sparsify(const Rows& rows, double share) {
  COPPICE_ASSERT(share >= 0 && share <= 1 && rows.width <= 65536);
  const auto kept = std::size_t(std::llround(share * double(rows.values.size())));
  COPPICE_ASSERT(kept <= std::numeric_limits<std::uint32_t>::max());
  const std::vector<bool> chosen = detail::largest_entries(rows, kept);
  SparseRows<Value> result{rows.width, {0}, {}, {}, {}};
  for (std::size_t i = 0; i < rows.count(); ++i) {
    float scale = 1;
    const float largest = detail::largest_magnitude(rows[i]);
    if constexpr (QuantisedEntry<Value>) scale = detail::step_of(largest, std::numeric_limits<Value>::max());
    for (std::size_t k = 0; k < rows.width; ++k) {
      if (!chosen[i * rows.width + k]) continue;
      result.columns.push_back(std::uint16_t(k));
      if constexpr (QuantisedEntry<Value>)
        result.values.push_back(detail::quantised<Value>(rows[i][k], scale));
      else
        result.values.push_back(rows[i][k]);
    }
    result.scales.push_back(scale);
    result.begins.push_back(std::uint32_t(result.values.size()));
  }
  return result;
}

/// The rows as floats again, zeros where nothing is stored.
template <SparseEntry Value>
Rows dequantise(const SparseRows<Value>& rows) {
  Rows result(rows.count(), rows.width);
  for (std::size_t i = 0; i < rows.count(); ++i)
    for (std::size_t e = rows.begin(i); e < rows.begin(i + 1); ++e)
      result[i][rows.columns[e]] = rows.scales[i] * float(rows.values[e]);
  return result;
}

/// Σ_k row[k] · x[k] for row i, in order. Error beside the entries' rounding: at most 6e-8 · (entries + 1) of
/// the sum of magnitudes. Precondition: x is as wide as the rows.
template <SparseEntry Value>
float dot(const SparseRows<Value>& rows, std::size_t i, std::span<const float> x) {
  COPPICE_ASSERT(x.size() == rows.width && i < rows.count());
  float sum = 0;
  for (std::size_t e = rows.begin(i); e < rows.begin(i + 1); ++e)
    sum += float(rows.values[e]) * x[rows.columns[e]];
  return rows.scales[i] * sum;
}

}  // namespace coppice
