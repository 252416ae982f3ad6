// Lights of the scene, ready to be traced from any point.
#pragma once

#include <coppice/light/local_light.hpp>
#include <coppice/relight/refine.hpp>
#include <coppice/relight/visibility.hpp>

namespace coppice {

/// Lights in packets of 16 in the order given, as structure of arrays. Lights that are off are traced as if
/// they were on; padding leaves have no place, give nothing to anyone and are never traced.
class LocalLightPackets {
 public:
  explicit LocalLightPackets(std::span<const LocalLight> lights) : count_(std::uint32_t(lights.size())) {
    const std::size_t padded = (lights.size() + 15) / 16 * 16;
    for (auto& field : fields_) field.assign(padded, 0.0f);
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const LocalLight& l = lights[i];
      const float values[field_count] = {
          l.position.x, l.position.y, l.position.z,          l.w, l.axis.x, l.axis.y, l.axis.z, l.offset,
          l.square,     l.area / pi,  luminance(l.intensity)};
      for (std::size_t f = 0; f < field_count; ++f) fields_[f][i] = values[f];
    }
  }

  std::uint32_t count() const { return count_; }
  std::uint32_t packet_count() const { return (count_ + 15) / 16; }

  /// Rays end a little before the lights, since those lie on surfaces.
  void aim(std::uint32_t packet, const vec3& origin, ShadowPacket& rays) const {
    for (std::uint32_t i = 0; i < 16; ++i) {
      const std::uint32_t l = 16 * packet + i;
      const float w = fields_[w_][l], x = fields_[x_][l] - w * origin.x, y = fields_[y_][l] - w * origin.y,
                  z = fields_[z_][l] - w * origin.z;
      const float distance = std::sqrt(x * x + y * y + z * z), scale = distance > 0 ? 1 / distance : 0;
      rays.direction_x[i] = x * scale, rays.direction_y[i] = y * scale, rays.direction_z[i] = z * scale;
      rays.t_max[i] = w > 0 ? distance * (1 - 1e-4f) : std::numeric_limits<float>::infinity();
    }
  }

  /// Lanes of lights above a receiver's horizon that shine towards it.
  std::uint32_t worth_tracing(std::uint32_t packet, const Receiver& receiver) const {
    const vec3 n = receiver.normal;
    std::uint32_t lanes = 0;
    for (std::uint32_t i = 0; i < 16; ++i) {
      const Arrival a = arrival(16 * packet + i, receiver.position);
      const float cosine = n.x * a.x + n.y * a.y + n.z * a.z;
      lanes |= std::uint32_t(a.geometry > 0 && cosine > receiver.horizon * a.distance) << i;
    }
    return lanes;
  }

  /// emission / (distance² + area/π) of light i at a point: what a sensor that faces it receives of its
  /// intensity where nothing is in between. 0 at the light itself, and of padding.
  float geometry(std::uint32_t i, const vec3& point) const { return arrival(i, point).geometry; }

  /// Times the cosine to a unit normal, 0 below its horizon.
  float irradiance_share(std::uint32_t i, const vec3& point, const vec3& normal) const {
    const Arrival a = arrival(i, point);
    const float cosine = normal.x * a.x + normal.y * a.y + normal.z * a.z;
    return a.distance > 0 ? a.geometry * std::max(0.0f, cosine / a.distance) : 0;
  }

  float luminance_of(std::uint32_t i) const { return fields_[luminance_][i]; }

 private:
  enum Field {
    x_,
    y_,
    z_,
    w_,
    axis_x_,
    axis_y_,
    axis_z_,
    offset_,
    square_,
    softening_,
    luminance_,
    field_count
  };

  struct Arrival {
    float x, y, z;  // to the light
    float distance, geometry;
  };

  Arrival arrival(std::uint32_t l, const vec3& point) const {
    const float w = fields_[w_][l];
    Arrival a{fields_[x_][l] - w * point.x, fields_[y_][l] - w * point.y, fields_[z_][l] - w * point.z, 0, 0};
    const float squared = a.x * a.x + a.y * a.y + a.z * a.z;
    a.distance = std::sqrt(squared);
    const float along = fields_[axis_x_][l] * a.x + fields_[axis_y_][l] * a.y + fields_[axis_z_][l] * a.z;
    const float toward = a.distance > 0 ? -along / a.distance : 0;
    const float s = std::min(1.0f, std::max(0.0f, toward + fields_[offset_][l]));
    const float emission = s * (1 - fields_[square_][l] + fields_[square_][l] * s);
    a.geometry = squared > 0 ? emission / (squared + fields_[softening_][l]) : 0.0f;
    return a;
  }

  std::uint32_t count_;
  std::array<std::vector<float>, field_count> fields_;
};
static_assert(LightPackets<LocalLightPackets>);

inline constexpr LocalLight padding_light{.w = 0};

/// Lights at the leaves.
inline std::vector<LocalLight> leaf_lights(const LightTree& tree, std::span<const LocalLight> lights) {
  std::vector<LocalLight> leaves;
  leaves.reserve(tree.leaf_count());
  for (const std::uint32_t light : tree.light_of_leaf)
    leaves.push_back(light == no_light ? padding_light : lights[light]);
  return leaves;
}

/// Error of irradiance at the middle of an edge if visibility · geometry is interpolated there: Σ over the
/// pilot lights, with their luminance, of |g_m - (g_a + g_b)/2| · cosine, as a share of what the lights give
/// that any of the three points sees, and a tenth of what all would give if nothing were in between. Where a
/// and b disagree, half of the greater is off whatever lies between.
inline double edge_error(const LocalLightPackets& pilot, const vec3& normal, const PilotView& a,
                         const PilotView& b, const PilotView& middle) {
  double error = 0, seen = 0, all = 0;
  for (std::uint32_t i = 0; i < pilot.count(); ++i) {
    const double share = pilot.luminance_of(i) * pilot.irradiance_share(i, middle.position, normal);
    if (!(share > 0)) continue;
    const double at_middle = pilot.geometry(i, middle.position);
    const auto relative = [&](const PilotView& end) {
      return bit_at(end.seen.data(), i) ? pilot.geometry(i, end.position) / at_middle : 0.0;
    };
    const double from_a = relative(a), from_b = relative(b), from_m = bit_at(middle.seen.data(), i) ? 1 : 0;
    const bool disagree = (from_a > 0) != (from_b > 0);
    all += share;
    if (from_a + from_b + from_m > 0) seen += share;
    error += share * (disagree ? 0.5 : std::min(1.0, std::fabs(from_m - 0.5 * (from_a + from_b))));
  }
  return all > 0 ? error / (seen + 0.1 * all) : 0;
}

}  // namespace coppice
