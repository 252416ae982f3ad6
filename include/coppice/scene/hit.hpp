// Where a camera ray ends.
#pragma once

#include <concepts>
#include <coppice/core/math.hpp>
#include <cstdint>
#include <optional>

namespace coppice {

/// Where a ray meets a triangle: position = (1 - u - v)·p0 + u·p1 + v·p2.
struct Hit {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;
  float t = 0;
  bool front = true;  ///< the ray meets the counter-clockwise side
};

/// Finds the nearest triangle along a ray. Safe to call from several threads.
template <class T>
concept RayTracer = requires(const T& tracer, vec3 v) {
  { tracer.closest(v, v) } -> std::same_as<std::optional<Hit>>;
};

}  // namespace coppice
