// A register of floats that behaves like one float, so that a closed form over REAL serves both.
#pragma once

#include <hwy/highway.h>
//
#include <coppice/shared/language.h>
#include <hwy/contrib/math/math-inl.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

static_assert(!HWY_HAVE_SCALABLE,
              "Lanes needs vectors of a fixed size: build for a target without SVE and RVV");

// The name of the target is part of the type: files compiled for different targets never mix their Lanes.
namespace coppice::inline HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A truth value a lane.
struct LaneMask {
  hn::Mask<hn::ScalableTag<float>> values;
};

inline LaneMask operator&(LaneMask a, LaneMask b) { return {hn::And(a.values, b.values)}; }
inline LaneMask operator|(LaneMask a, LaneMask b) { return {hn::Or(a.values, b.values)}; }
inline LaneMask operator!(LaneMask a) { return {hn::Not(a.values)}; }
inline bool any(LaneMask a) { return !hn::AllFalse(hn::ScalableTag<float>(), a.values); }
inline bool all(LaneMask a) { return hn::AllTrue(hn::ScalableTag<float>(), a.values); }

/// The mask whose lane i is bit i of `bits`.
inline LaneMask lane_mask(std::uint64_t bits) {
  std::uint8_t bytes[8];
  std::memcpy(bytes, &bits, 8);
  return {hn::LoadMaskBits(hn::ScalableTag<float>(), bytes)};
}

/// Bit i is lane i of the mask.
inline std::uint64_t bits_of(LaneMask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(hn::ScalableTag<float>(), mask.values, bytes);
  std::uint64_t bits = 0;
  std::memcpy(&bits, bytes, 8);
  return bits;
}

/// The mask of the lanes below `count`.
inline LaneMask first_lanes(std::size_t count) {
  const hn::ScalableTag<float> tag;
  return {hn::FirstN(tag, count < hn::MaxLanes(tag) ? count : hn::MaxLanes(tag))};
}

/// `width` floats in the widest register of the compiler's target. Arithmetic is IEEE, lane by lane; a float
/// converts to all lanes. The functions below have the names and, where nothing else is said, the meaning of
/// those for one float.
struct Lanes {
  using Tag = hn::ScalableTag<float>;
  using Register = hn::Vec<Tag>;
  static constexpr std::size_t width = hn::MaxLanes(Tag());

  Register values;

  Lanes() = default;
  Lanes(float x) : values(hn::Set(Tag(), x)) {}  // NOLINT: implicit, as from float to double
  explicit Lanes(Register x) : values(x) {}

  /// The `width` floats at `from`, at any alignment.
  static Lanes load(const float* from) { return Lanes(hn::LoadU(Tag(), from)); }
  /// Writes `width` floats to `to`, at any alignment.
  void store(float* to) const { hn::StoreU(values, Tag(), to); }
};

// Not friends inside the class: GCC would compile those for the baseline target, whatever the pragma says.

inline Lanes operator+(Lanes a, Lanes b) { return Lanes(hn::Add(a.values, b.values)); }
inline Lanes operator-(Lanes a, Lanes b) { return Lanes(hn::Sub(a.values, b.values)); }
inline Lanes operator*(Lanes a, Lanes b) { return Lanes(hn::Mul(a.values, b.values)); }
inline Lanes operator/(Lanes a, Lanes b) { return Lanes(hn::Div(a.values, b.values)); }
inline Lanes operator-(Lanes a) { return Lanes(hn::Neg(a.values)); }
inline Lanes& operator+=(Lanes& a, Lanes b) { return a = a + b; }
inline Lanes& operator-=(Lanes& a, Lanes b) { return a = a - b; }
inline Lanes& operator*=(Lanes& a, Lanes b) { return a = a * b; }
inline Lanes& operator/=(Lanes& a, Lanes b) { return a = a / b; }

inline LaneMask operator<(Lanes a, Lanes b) { return {hn::Lt(a.values, b.values)}; }
inline LaneMask operator<=(Lanes a, Lanes b) { return {hn::Le(a.values, b.values)}; }
inline LaneMask operator>(Lanes a, Lanes b) { return {hn::Gt(a.values, b.values)}; }
inline LaneMask operator>=(Lanes a, Lanes b) { return {hn::Ge(a.values, b.values)}; }
inline LaneMask operator==(Lanes a, Lanes b) { return {hn::Eq(a.values, b.values)}; }
/// Also where either is not a number, as for one float; Highway's Ne leaves those out on x86.
inline LaneMask operator!=(Lanes a, Lanes b) { return !(a == b); }

/// a where the mask is set, else b.
inline Lanes select(LaneMask mask, Lanes a, Lanes b) {
  return Lanes(hn::IfThenElse(mask.values, a.values, b.values));
}
inline Lanes min(Lanes a, Lanes b) { return Lanes(hn::Min(a.values, b.values)); }
inline Lanes max(Lanes a, Lanes b) { return Lanes(hn::Max(a.values, b.values)); }
inline Lanes abs(Lanes a) { return Lanes(hn::Abs(a.values)); }
inline Lanes sqrt(Lanes a) { return Lanes(hn::Sqrt(a.values)); }
/// a·b + c, in one rounding where the target has the instruction.
inline Lanes mul_add(Lanes a, Lanes b, Lanes c) { return Lanes(hn::MulAdd(a.values, b.values, c.values)); }

/// e^max(a, -69): never below 1e-30, so that no product of a few such numbers is denormal (a path full of
/// them ran 4.5× slower). Domain a <= 88; relative error there below 1.2e-7 for a >= -69.
inline Lanes exp(Lanes a) { return Lanes(hn::Exp(Lanes::Tag(), max(a, -69.0f).values)); }
/// Natural logarithm. Domain: a > 0; relative error below 1.2e-7 there.
inline Lanes log(Lanes a) { return Lanes(hn::Log(Lanes::Tag(), a.values)); }
/// log(1 + a), also where a is tiny. Domain: a > -1; relative error below 2.4e-7 there.
inline Lanes log1p(Lanes a) { return Lanes(hn::Log1p(Lanes::Tag(), a.values)); }
/// x^n, 0 at x = 0. Domain: x >= 0, n > 0, x^n <= 1e38; below 1e-30 the result is 1e-30. Relative error
/// below 3e-7 · (1 + |n log x|).
inline Lanes pow_positive(Lanes x, Lanes n) {
  const Lanes tiny = std::numeric_limits<float>::min();
  return select(x > 0.0f, exp(n * log(max(x, tiny))), 0.0f);
}
/// The sum of all lanes, always in the same order for the same width.
inline float sum_of_lanes(Lanes a) { return hn::GetLane(hn::SumOfLanes(Lanes::Tag(), a.values)); }

}  // namespace coppice::inline HWY_NAMESPACE

namespace coppice {

template <>
struct ScalarOf<Lanes> {
  using type = float;
};

/// x^n, 0 at x = 0. Domain: x >= 0, n > 0.
template <std::floating_point T>
T pow_positive(T x, T n) {
  return x > 0 ? std::pow(x, n) : T(0);
}
/// The sum of the only lane.
inline float sum_of_lanes(float a) { return a; }

}  // namespace coppice
