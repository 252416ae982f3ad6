// A matrix of floats in 8 or 16 bits an entry, with steps that grow with the entry.
#pragma once

#include <coppice/pca/quantised_rows.hpp>

namespace coppice {

/// Rows whose entry (i, k) is about scales[i] · q·|q|, q = values[i · width + k]: as telephones compand
/// speech. For rows that hold entries of very different magnitude, all of which count, as those of a transfer
/// matrix.
template <QuantisedEntry Value>
struct SquareLawRows {
  std::size_t width = 0;
  std::vector<Value> values;
  std::vector<float> scales;  ///< a row: its largest magnitude over the square of the largest integer

  std::size_t count() const { return scales.size(); }
  std::span<const Value> operator[](std::size_t i) const {
    return std::span(values).subspan(i * width, width);
  }
  std::size_t bytes() const { return values.size() * sizeof(Value) + scales.size() * sizeof(float); }
};

namespace detail {

template <QuantisedEntry Value>
float square_law(Value q) {
  return float(q) * std::abs(float(q));
}

}  // namespace detail

/// The rows rounded to the nearest that there is. With L the largest magnitude of a row and N = 127 or
/// 32,767, an entry x comes back within √(|x| L)/N + L/(2N²), and float rounding: at 8 bits 0.8% of the
/// largest, 8% of those that are a hundred times smaller, where even steps err by up to 40%. Precondition:
/// finite values.
template <QuantisedEntry Value>
SquareLawRows<Value> quantise_by_squares(const Rows& rows) {
  const double most = std::numeric_limits<Value>::max();
  SquareLawRows<Value> result{rows.width, std::vector<Value>(rows.values.size()), {}};
  for (std::size_t i = 0; i < rows.count(); ++i) {
    const double step = double(detail::step_of(detail::largest_magnitude(rows[i]), float(most * most)));
    result.scales.push_back(float(step));
    for (std::size_t k = 0; k < rows.width && step > 0; ++k) {
      const double x = double(rows[i][k]), u = std::abs(x) / step, q = std::floor(std::sqrt(u));
      const double nearest = u - q * q > (q + 1) * (q + 1) - u ? q + 1 : q;
      result.values[i * rows.width + k] = Value(std::copysign(std::min(nearest, most), x));
    }
  }
  return result;
}

/// The rows as floats again.
template <QuantisedEntry Value>
Rows dequantise(const SquareLawRows<Value>& rows) {
  Rows result(rows.count(), rows.width);
  for (std::size_t i = 0; i < rows.count(); ++i)
    for (std::size_t k = 0; k < rows.width; ++k)
      result[i][k] = rows.scales[i] * detail::square_law(rows[i][k]);
  return result;
}

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Σ_k row[k] · x[k] for row i. Error beside the row's rounding: at most (width/4 + 2) · 6e-8 of the sum of
/// magnitudes. Precondition: x is as wide as the rows.
template <QuantisedEntry Value>
float dot(const SquareLawRows<Value>& rows, std::size_t i, std::span<const float> x) {
  COPPICE_ASSERT(x.size() == rows.width && i < rows.count());
  const Value* row = rows.values.data() + i * rows.width;
  Lanes even = 0.0f, odd = 0.0f;
  const auto entries = [row](std::size_t k) {
    const Lanes q = load_integers(row + k);
    return q * abs(q);
  };
  std::size_t k = 0;
  for (; k + 2 * Lanes::width <= x.size(); k += 2 * Lanes::width) {
    even = mul_add(entries(k), Lanes::load(&x[k]), even);
    odd = mul_add(entries(k + Lanes::width), Lanes::load(&x[k + Lanes::width]), odd);
  }
  float sum = sum_of_lanes(even + odd);
  for (; k < x.size(); ++k) sum += detail::square_law(row[k]) * x[k];
  return rows.scales[i] * sum;
}

}  // namespace coppice::inline HWY_NAMESPACE
