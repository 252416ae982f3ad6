// Vectors (GLM) and the few closed forms on them that every module needs.
#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>

namespace coppice {

using glm::cross;
using glm::dot;
using glm::length;
using glm::mat3;
using glm::mat4;
using glm::normalize;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

inline constexpr float pi = std::numbers::pi_v<float>;

/// Luminance of linear RGB (Rec. 709 primaries).
inline float luminance(const vec3& rgb) { return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z; }

inline bool is_finite(const vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// v / |v|, or `fallback` where v is shorter than 1e-37 or not finite: never NaN.
inline vec3 normalize_or(const vec3& v, const vec3& fallback) {
  const float largest = std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
  if (!is_finite(v) || !(largest > 1e-37f)) return fallback;
  return normalize(v / largest);
}

/// The part of the unit vector t across the unit vector n, normalised; zero where t is zero or so nearly
/// along n that rounding would decide its direction.
inline vec3 tangent_across(const vec3& t, const vec3& n) {
  const vec3 across = t - dot(t, n) * n;
  return dot(across, across) > 1e-6f * dot(t, t) ? normalize(across - dot(across, n) * n) : vec3(0);
}

/// Two unit vectors that complete the unit vector n to a right-handed frame, without a branch on its
/// direction other than the sign of z (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017).
inline void make_frame(const vec3& n, vec3& tangent, vec3& bitangent) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  const float b = n.x * n.y * a;
  tangent = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  bitangent = {b, sign + n.y * n.y * a, -n.y};
}

}  // namespace coppice
