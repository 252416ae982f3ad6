// Cones packed into the lobe of a BRDF: where visibility is asked for (SG, section 5, Figure 4).
#pragma once

#include <coppice/core/config.hpp>
#include <coppice/sg/lobe_integral.hpp>

namespace coppice {

/// Equal circles packed into the unit disc: 1, 3, 7, 13 or 19, as closely as is known for these numbers.
struct DiscPacking {
  std::array<vec2, 19> centres{};
  int count = 0;
  float radius = 1;
};

/// One ring of `number` circles at `distance` from the centre, the first at `turn` radians.
inline void add_ring(DiscPacking& packing, int number, float distance, float turn) {
  for (int i = 0; i < number; ++i) {
    const float angle = turn + 2 * pi * float(i) / float(number);
    packing.centres[std::size_t(packing.count++)] = distance * vec2(std::cos(angle), std::sin(angle));
  }
}

/// Rings 1; 3; 1 + 6; 3 + 10; 1 + 6 + 12. Radii 1, 1/(1 + 2/√3), 1/3, 1/(2 + √5) and 1/(1 + √2 + √6): the
/// circles cover 100, 65, 78, 72 and 80% of the disc. Precondition: one of these counts.
inline DiscPacking disc_packing(int count) {
  COPPICE_ASSERT(count == 1 || count == 3 || count == 7 || count == 13 || count == 19);
  DiscPacking packing;
  switch (count) {
    case 3:
      packing.radius = 0.46410162f;
      add_ring(packing, 3, 1 - packing.radius, 0.5f * pi);
      break;
    case 7:
      packing.radius = 1.0f / 3;
      add_ring(packing, 1, 0, 0);
      add_ring(packing, 6, 1 - packing.radius, 0);
      break;
    case 13:
      packing.radius = 0.23606798f;
      add_ring(packing, 3, 1.1547005f * packing.radius, 0.5f * pi);
      add_ring(packing, 10, 1 - packing.radius, 0);
      break;
    case 19:
      packing.radius = 0.20560465f;
      add_ring(packing, 1, 0, 0);
      add_ring(packing, 6, 2 * packing.radius, 0);
      add_ring(packing, 12, 1 - packing.radius, pi / 12);
      break;
    default:
      add_ring(packing, 1, 0, 0);
  }
  return packing;
}

/// Cones in the local frame of a BRDF, each as the Gaussian that falls to a half at its edge (SG Eq. 5).
struct LobeCones {
  std::array<SgShape, 19> shapes{};  ///< the first `count` are meant; no axis is below the horizon
  std::array<float, 19> shares{};    ///< of the lobe's energy, about; their sum is 1
  int count = 0;
};

/// Where a lobe is above some part of its height: an ellipse about a direction, by angles.
struct LobeEllipse {
  vec3 centre;     ///< unit, in the plane of incidence, not below the horizon
  vec3 up;         ///< unit, across centre, in that plane, towards the normal
  vec3 across;     ///< unit, across that plane
  float half_up;   ///< radians, in the plane
  float half_out;  ///< radians, across it
};

namespace detail {

inline vec3 turned(const vec3& from, const vec3& towards, float angle) {
  return from * std::cos(angle) + towards * std::sin(angle);
}

/// The angle in [0, most] from which on the lobe is below `level`, from a direction where it is above.
inline float reach(const BrdfLobes& lobes, const vec3& from, const vec3& towards, float most, float level) {
  float low = 0, high = most;
  for (int i = 0; i < 10; ++i) {
    const float middle = 0.5f * (low + high);
    (lobes_value(lobes, turned(from, towards, middle)) > level ? low : high) = middle;
  }
  return high;
}

/// The axis, lifted above the horizon, where the sum of the Gaussians is greatest.
inline vec3 highest_axis(const BrdfLobes& lobes) {
  vec3 best(0, 0, 1);
  float height = -1;
  for (int k = 0; k < lobes.count; ++k) {
    const vec3 a = lobes.lobes[std::size_t(k)].shape.axis;
    const vec3 d = normalize_or(vec3(a.x, a.y, std::max(a.z, 1e-4f)), vec3(0, 0, 1));
    const float value = lobes_value(lobes, d);
    if (value > height) best = d, height = value;
  }
  return best;
}

inline bool is_cosine(const BrdfLobes& lobes) {
  return lobes.times_cosine && lobes.count == 1 && lobes.lobes[0].shape.sharpness == 0;
}

/// Circles of the disc as cones over the hemisphere, (x, y) of the disc those of the axis: each has the same
/// share of the cosine.
inline LobeCones cosine_cones(const DiscPacking& packing) {
  LobeCones cones;
  cones.count = packing.count;
  for (int i = 0; i < packing.count; ++i) {
    const vec2 at = packing.centres[std::size_t(i)];
    const float z = std::sqrt(1 - dot(at, at));
    const float size = std::min(0.5f * packing.radius * packing.radius / z, 1.0f);  // solid angle over 2π
    cones.shapes[std::size_t(i)] = {vec3(at, z), 0.6931472f / size};
    cones.shares[std::size_t(i)] = 1 / float(packing.count);
  }
  return cones;
}

}  // namespace detail

/// The ellipse where the lobe is above `level` of its height. Precondition: lobes.count > 0, 0 < level < 1.
inline LobeEllipse lobe_ellipse(const BrdfLobes& lobes, float level) {
  const vec3 peak = detail::highest_axis(lobes);
  const float floor = level * lobes_value(lobes, peak);
  const vec3 up = normalize_or(cross(peak, lobes.across), vec3(1, 0, 0));
  const float upward = up.z < 0 ? -1.0f : 1.0f;
  const float elevation = std::atan2(peak.z, std::sqrt(peak.x * peak.x + peak.y * peak.y));
  const float above = detail::reach(lobes, peak, upward * up, pi - elevation, floor);
  const float below = detail::reach(lobes, peak, -upward * up, elevation, floor);
  LobeEllipse ellipse;
  ellipse.centre = normalize(detail::turned(peak, upward * up, 0.5f * (above - below)));
  ellipse.up = normalize_or(cross(ellipse.centre, lobes.across), up) * upward;
  ellipse.across = lobes.across;
  ellipse.half_up = 0.5f * (above + below);
  ellipse.half_out = detail::reach(lobes, ellipse.centre, lobes.across, 0.5f * pi, floor);
  return ellipse;
}

/// The circles of the packing in the ellipse, the longer axis along its own; each counts by the lobe's value
/// at its axis and its solid angle.
inline LobeCones cones_in(const BrdfLobes& lobes, const LobeEllipse& ellipse, const DiscPacking& packing) {
  LobeCones cones;
  cones.count = packing.count;
  float sum = 0;
  for (std::size_t i = 0; i < std::size_t(packing.count); ++i) {
    const vec2 at = packing.centres[i] * vec2(ellipse.half_up, ellipse.half_out);
    const float angle = std::max(length(at), 1e-9f), size = ellipse.half_up * ellipse.half_out;
    const float edge = packing.radius * std::sqrt(size * std::sin(angle) / angle);
    vec3 axis = detail::turned(ellipse.centre, (at.x * ellipse.up + at.y * ellipse.across) / angle,
                               std::sin(angle) > 0 ? angle : 0);
    axis = normalize(vec3(axis.x, axis.y, std::max(axis.z, std::sin(0.5f * edge))));
    cones.shapes[i] = {axis, sg_cone_sharpness(std::max(edge, 1e-4f))};
    cones.shares[i] = std::max(lobes_value(lobes, axis), 0.0f) * edge * edge;
    sum += cones.shares[i];
  }
  for (std::size_t i = 0; i < std::size_t(packing.count); ++i)
    cones.shares[i] = sum > 0 ? cones.shares[i] / sum : 1 / float(packing.count);
  return cones;
}

/// The part of a lobe's height down to which this many cones are packed: the more, the lower. What gave the
/// least error of the mean visibility by random occluders; GGX, with three Gaussians, has the longest tails.
inline float cone_level(const BrdfLobes& lobes, int count) {
  const bool tails = lobes.count > 2;
  if (count <= 1) return tails ? 0.2f : 0.45f;
  if (count <= 3) return tails ? 0.08f : 0.22f;
  if (count <= 7) return tails ? 0.03f : 0.14f;
  if (count <= 13) return tails ? 0.025f : 0.1f;
  return tails ? 0.015f : 0.07f;
}

/// 1, 3, 7, 13 or 19 cones that share the lobe, for the mean visibility over it: Lambert's over the
/// hemisphere, each with an equal share of the cosine, others in the ellipse down to cone_level. None has its
/// axis below the horizon. Precondition: lobes.count > 0. Error and cover: docs/sg_materials.md.
inline LobeCones cones_of(const BrdfLobes& lobes, int count) {
  COPPICE_ASSERT(lobes.count > 0);
  const DiscPacking packing = disc_packing(count);
  if (detail::is_cosine(lobes)) return detail::cosine_cones(packing);
  return cones_in(lobes, lobe_ellipse(lobes, cone_level(lobes, count)), packing);
}

}  // namespace coppice
