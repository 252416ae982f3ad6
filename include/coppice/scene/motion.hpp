// How a rigid object moves: keyframes, and the transform that they give at a time.
#pragma once

#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace coppice {

/// Turns, then moves: from an object's own frame to the world. Keeps lengths and angles.
struct RigidTransform {
  glm::quat rotation{1, 0, 0, 0};  ///< (w, x, y, z), unit
  vec3 translation{0};

  vec3 point(const vec3& p) const { return rotation * p + translation; }
  vec3 direction(const vec3& d) const { return rotation * d; }

  /// From the world to the object's own frame.
  RigidTransform inverse() const {
    const glm::quat back = glm::conjugate(rotation);
    return {back, -(back * translation)};
  }
};

/// First `inner`, then `outer`.
inline RigidTransform operator*(const RigidTransform& outer, const RigidTransform& inner) {
  return {outer.rotation * inner.rotation, outer.point(inner.translation)};
}

/// What lies between two keyframes (glTF 2.0, appendix C).
enum class Interpolation : std::uint8_t {
  step,          ///< the earlier value
  linear,        ///< the straight line; for rotations the shorter great arc, at constant speed
  cubic_spline,  ///< Hermite, with a tangent in and out at every key
};

namespace detail {

template <class Value>
inline constexpr Value at_rest{0.0f, 0.0f, 0.0f};
template <>
inline constexpr glm::quat at_rest<glm::quat>{1, 0, 0, 0};

inline vec3 interpolate(const vec3& a, const vec3& b, float x) { return glm::mix(a, b, x); }
inline glm::quat interpolate(const glm::quat& a, const glm::quat& b, float x) { return glm::slerp(a, b, x); }

inline vec3 valid(const vec3& value, const vec3&) { return value; }

// A unit quaternion: `fallback` where a spline runs through zero, which is no rotation.
inline glm::quat valid(const glm::quat& q, const glm::quat& fallback) {
  const float largest =
      std::fmax(std::fmax(std::fabs(q.w), std::fabs(q.x)), std::fmax(std::fabs(q.y), std::fabs(q.z)));
  return largest > 1e-6f && std::isfinite(largest) ? glm::normalize(q * (1 / largest)) : fallback;
}

template <class Value>
Value hermite(const Value& from, const Value& leave, const Value& arrive, const Value& to, float x) {
  const float rest = 1 - x;
  return from * ((1 + 2 * x) * rest * rest) + leave * (x * rest * rest) + arrive * (x * x * (x - 1)) +
         to * (x * x * (3 - 2 * x));
}

}  // namespace detail

/// Values at times, and what lies between them. Value: vec3 (translations) or glm::quat (rotations, unit).
/// Without keys it is at rest: zero, or no rotation.
template <class Value>
struct Keyframes {
  Interpolation interpolation = Interpolation::linear;
  std::vector<float> times;   ///< seconds, strictly ascending, finite
  std::vector<Value> values;  ///< one a time; for cubic_spline three: tangent in, value, tangent out, the
                              ///< tangents per second

  std::size_t values_a_key() const { return interpolation == Interpolation::cubic_spline ? 3 : 1; }

  /// The value of a key, without its tangents.
  const Value& value(std::size_t key) const {
    return interpolation == Interpolation::cubic_spline ? values[3 * key + 1] : values[key];
  }

  /// The value at a time in seconds: that of the first key before it, that of the last after it. Rotations
  /// come out unit. Precondition: time is not NaN. Cost: logarithmic in the keys.
  Value at(float time) const {
    COPPICE_ASSERT(!std::isnan(time) && values.size() == values_a_key() * times.size());
    if (times.empty()) return detail::at_rest<Value>;
    const auto next = std::size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin());
    if (next == 0) return value(0);
    return next == times.size() ? value(next - 1) : between(next - 1, time);
  }

 private:
  Value between(std::size_t key, float time) const {
    const float span = times[key + 1] - times[key], x = (time - times[key]) / span;
    if (interpolation == Interpolation::step) return value(key);
    const Value mixed = interpolation == Interpolation::linear
                            ? detail::interpolate(value(key), value(key + 1), x)
                            : detail::hermite(value(key), values[3 * key + 2] * span,
                                              values[3 * key + 3] * span, value(key + 1), x);
    return detail::valid(mixed, value(key));
  }
};

/// One moving frame in its parent frame: turned by `rotation`, then moved by `translation`.
struct Joint {
  Keyframes<vec3> translation;
  Keyframes<glm::quat> rotation;

  RigidTransform at(float time) const { return {rotation.at(time), translation.at(time)}; }

  /// Time of the last key in seconds; 0 without keys.
  float duration() const {
    const float translated = translation.times.empty() ? 0 : translation.times.back();
    return std::fmax(translated, rotation.times.empty() ? 0 : rotation.times.back());
  }
};

/// A chain of moving frames, each within the one before; the first is in the world, the last is the object's
/// own. An empty chain is at rest in the world.
struct Motion {
  std::vector<Joint> joints;

  /// The object's transform at a time in seconds, which is clamped to each joint's keys. Precondition: time
  /// is not NaN. Error: rounding, some 1e-7 of the joints' distances for each of them.
  RigidTransform at(float time) const {
    RigidTransform to_world;
    for (const Joint& joint : joints) to_world = to_world * joint.at(time);
    to_world.rotation = glm::normalize(to_world.rotation);
    return to_world;
  }

  /// Seconds until the last key; the object rests from there on.
  float duration() const {
    float last = 0;
    for (const Joint& joint : joints) last = std::fmax(last, joint.duration());
    return last;
  }
};

}  // namespace coppice
