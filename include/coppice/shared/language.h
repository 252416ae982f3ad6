// What lets a header of this folder compile as C++20 and as GLSL (scalar block layout).
// In GLSL the including shader defines COPPICE_GLSL. Closed forms over `REAL` become templates in C++,
// so that the same line serves one float, a SIMD register of floats, and a shader invocation.
#ifndef COPPICE_SHARED_LANGUAGE_H
#define COPPICE_SHARED_LANGUAGE_H

#ifdef COPPICE_GLSL

#define COPPICE_BEGIN
#define COPPICE_END
#define COPPICE_FUNCTION
#define COPPICE_FUNCTION_OF_REAL
#define COPPICE_STRUCT_OF_REAL
#define COPPICE_OF_REAL(name) name
#define REAL float
#define COPPICE_SCALAR float
#define COPPICE_CONST const

uint count_trailing_zeros(uint x) { return uint(findLSB(x)); }
float select(bool condition, float a, float b) { return condition ? a : b; }
float mul_add(float a, float b, float c) { return a * b + c; }

// log(1 + x); near 0 by 2 atanh(x / (2 + x)), because Vulkan bounds only the absolute error of log there.
float log1p(float x) {
  if (abs(x) >= 0.25f) return log(1.0f + x);
  const float s = x / (2.0f + x);
  const float s2 = s * s;
  return 2.0f * s * (1.0f + s2 * (1.0f / 3.0f + s2 * (1.0f / 5.0f + s2 / 7.0f)));
}

#else

#include <bit>
#include <cmath>
#include <concepts>
#include <coppice/core/math.hpp>
#include <cstdint>

#define COPPICE_BEGIN namespace coppice {
#define COPPICE_END }
// In C++ always inlined: a call for each register of lights costs 2.6 times the time of GGX, and a source
// that is compiled for newer processors must leave no copy under a name that all sources share (src/kernels).
#ifdef __GNUC__
#define COPPICE_FUNCTION [[gnu::always_inline]] inline
#else
#define COPPICE_FUNCTION inline
#endif
#define COPPICE_FUNCTION_OF_REAL \
  template <class REAL>          \
  COPPICE_FUNCTION
#define COPPICE_STRUCT_OF_REAL template <class REAL>
#define COPPICE_OF_REAL(name) name<REAL>
#define COPPICE_SCALAR Scalar<REAL>  // one number a call, where REAL may be a register of them
#define COPPICE_CONST inline constexpr

namespace coppice {
using uint = std::uint32_t;
/// Number of zero bits below the lowest set bit. Precondition: x != 0.
inline uint count_trailing_zeros(uint x) { return uint(std::countr_zero(x)); }

/// The number that all lanes of a REAL can share: REAL itself unless it is a SIMD register (core/simd.hpp).
template <class REAL>
struct ScalarOf {
  using type = REAL;
};
template <class REAL>
using Scalar = typename ScalarOf<REAL>::type;

// GLSL's built-in functions for one number. Those for a SIMD register are found by argument-dependent lookup.
using std::abs;
using std::exp;
using std::log;
using std::log1p;
using std::sqrt;

template <std::floating_point T>
constexpr T max(T a, T b) {
  return a < b ? b : a;
}
template <std::floating_point T>
constexpr T min(T a, T b) {
  return b < a ? b : a;
}
/// condition ? a : b.
template <std::floating_point T>
constexpr T select(bool condition, T a, T b) {
  return condition ? a : b;
}
/// a·b + c, fused or not as the compiler likes.
template <std::floating_point T>
constexpr T mul_add(T a, T b, T c) {
  return a * b + c;
}
}  // namespace coppice

#endif
#endif
