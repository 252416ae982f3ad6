// A matrix of floats in 8 or 16 bits an entry, with a scale for each row.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <cmath>
#include <concepts>
#include <coppice/pca/rows.hpp>
#include <cstdint>
#include <limits>

namespace coppice {

/// What an entry is rounded to.
template <class Value>
concept QuantisedEntry = std::same_as<Value, std::int8_t> || std::same_as<Value, std::int16_t>;

/// Rows whose entry (i, k) is about scales[i] · values[i · width + k].
template <QuantisedEntry Value>
struct QuantisedRows {
  std::size_t width = 0;
  std::vector<Value> values;
  std::vector<float> scales;  ///< a row: its step, 0 for rows of zeros

  std::size_t count() const { return scales.size(); }
  std::span<const Value> operator[](std::size_t i) const {
    return std::span(values).subspan(i * width, width);
  }
  /// Bytes of the entries and the scales.
  std::size_t bytes() const { return values.size() * sizeof(Value) + scales.size() * sizeof(float); }
};

namespace detail {

/// The step at which the largest of these magnitudes is `limit` steps: rounded down, so that it never comes
/// back larger, yet at least the least normal float.
inline float step_of(float largest, float limit) {
  if (!(largest > 0)) return 0;
  float step = largest / limit;
  if (double(step) * double(limit) > double(largest)) step = std::nextafter(step, 0.0f);
  return std::max(step, std::numeric_limits<float>::min());
}

inline float largest_magnitude(std::span<const float> row) {
  float largest = 0;
  for (const float x : row) {
    COPPICE_ASSERT(std::isfinite(x));
    largest = std::max(largest, std::abs(x));
  }
  return largest;
}

template <QuantisedEntry Value>
Value quantised(float x, float step) {
  if (step == 0) return 0;
  const double limit = std::numeric_limits<Value>::max();
  return Value(std::clamp(std::nearbyint(double(x) / double(step)), -limit, limit));
}

}  // namespace detail

/// The rows rounded (PCA section 4.4, there to 16 bits). Every entry comes back within 0.503 steps: half of
/// one by rounding, the rest by float arithmetic. A step is 1/127 or 1/32767 of the row's largest magnitude,
/// yet at least 1.2e-38, so that subnormal entries may become 0. Precondition: finite values.
template <QuantisedEntry Value>
QuantisedRows<Value> quantise(const Rows& rows) {
  const float limit = std::numeric_limits<Value>::max();
  QuantisedRows<Value> result{rows.width, std::vector<Value>(rows.values.size()), {}};
  result.scales.resize(rows.count());
  for (std::size_t i = 0; i < rows.count(); ++i) {
    result.scales[i] = detail::step_of(detail::largest_magnitude(rows[i]), limit);
    for (std::size_t k = 0; k < rows.width; ++k)
      result.values[i * rows.width + k] = detail::quantised<Value>(rows[i][k], result.scales[i]);
  }
  return result;
}

/// The rows as floats again.
template <QuantisedEntry Value>
Rows dequantise(const QuantisedRows<Value>& rows) {
  Rows result(rows.count(), rows.width);
  for (std::size_t i = 0; i < rows.count(); ++i)
    for (std::size_t k = 0; k < rows.width; ++k) result[i][k] = rows.scales[i] * float(rows[i][k]);
  return result;
}

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// As many integers as Lanes holds floats, converted.
template <QuantisedEntry Value>
Lanes load_integers(const Value* from) {
  const hn::Rebind<Value, Lanes::Tag> few;
  const hn::Rebind<std::int32_t, Lanes::Tag> wide;
  return Lanes(hn::ConvertTo(Lanes::Tag(), hn::PromoteTo(wide, hn::LoadU(few, from))));
}

/// Σ_k row[k] · x[k] for row i. Error beside the row's rounding: at most (width/4 + 2) · 6e-8 of the sum of
/// magnitudes. Precondition: x is as wide as the rows.
template <QuantisedEntry Value>
float dot(const QuantisedRows<Value>& rows, std::size_t i, std::span<const float> x) {
  COPPICE_ASSERT(x.size() == rows.width && i < rows.count());
  const Value* row = rows.values.data() + i * rows.width;
  Lanes even = 0.0f, odd = 0.0f;
  std::size_t k = 0;
  for (; k + 2 * Lanes::width <= x.size(); k += 2 * Lanes::width) {
    even = mul_add(load_integers(row + k), Lanes::load(&x[k]), even);
    odd = mul_add(load_integers(row + k + Lanes::width), Lanes::load(&x[k + Lanes::width]), odd);
  }
  if (k + Lanes::width <= x.size()) {
    even = mul_add(load_integers(row + k), Lanes::load(&x[k]), even);
    k += Lanes::width;
  }
  float sum = sum_of_lanes(even + odd);
  for (; k < x.size(); ++k) sum += float(row[k]) * x[k];
  return rows.scales[i] * sum;
}

/// to[k] += factor · row[k] for row i. Precondition: `to` is as wide as the rows.
template <QuantisedEntry Value>
void add_scaled(float factor, const QuantisedRows<Value>& rows, std::size_t i, std::span<float> to) {
  COPPICE_ASSERT(to.size() == rows.width && i < rows.count());
  const Value* row = rows.values.data() + i * rows.width;
  const float step = factor * rows.scales[i];
  std::size_t k = 0;
  for (; k + Lanes::width <= to.size(); k += Lanes::width)
    mul_add(step, load_integers(row + k), Lanes::load(&to[k])).store(&to[k]);
  for (; k < to.size(); ++k) to[k] += step * float(row[k]);
}

}  // namespace coppice::inline HWY_NAMESPACE
