// Values in [0, 1] as 8- or 16-bit integers.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <limits>

namespace coppice {

template <class Q>
concept Quantised = std::same_as<Q, std::uint8_t> || std::same_as<Q, std::uint16_t>;

/// Largest quantised value; it stands for 1.
template <Quantised Q>
inline constexpr float quantised_one = float(std::numeric_limits<Q>::max());

/// The nearest level of v in [0, 1]; outside it is clamped. |dequantise(quantise(v)) - v| <= 1/510 (8 bit),
/// 1/131070 (16 bit), each plus 1.2e-7 of float rounding, and 0 and 1 are exact. Precondition: v is not NaN.
template <Quantised Q>
constexpr Q quantise(float v) {
  return Q(std::clamp(v, 0.0f, 1.0f) * quantised_one<Q> + 0.5f);
}

template <Quantised Q>
constexpr float dequantise(Q q) {
  return float(q) * (1.0f / quantised_one<Q>);
}

}  // namespace coppice
