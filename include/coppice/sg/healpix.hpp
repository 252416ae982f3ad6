// HEALPix in the ring scheme: pixels of equal area on rings about +Y.
#pragma once

#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <cstdint>
#include <vector>

namespace coppice {

/// The sphere in 12 nside² pixels of equal area (Górski et al. 2005, section 5). Rings run from +Y to -Y; the
/// azimuth is atan2(d.z, d.x), as that of environment maps. Any nside from 1 to 8192 will do, a power of two
/// or not. Closed forms in double, which work from 1 - |y| near the poles: 1 - |y| = (x² + z²)/(1 + |y|).
class Healpix {
 public:
  explicit Healpix(int nside) : nside_(nside) { COPPICE_ASSERT(nside >= 1 && nside <= 8192); }

  int nside() const { return nside_; }
  std::uint32_t pixel_count() const { return 12 * square(std::uint32_t(nside_)); }
  /// Steradians of each pixel.
  double pixel_area() const { return 4 * std::numbers::pi / pixel_count(); }

  /// Unit direction of a pixel's centre, to a few ulp also next to the poles. Precondition: pixel <
  /// pixel_count().
  vec3 centre(std::uint32_t pixel) const {
    COPPICE_ASSERT(pixel < pixel_count());
    const std::uint32_t n = std::uint32_t(nside_), cap = 2 * n * (n - 1);
    if (pixel < cap) return cap_centre(pixel, 1);
    if (pixel >= pixel_count() - cap) return south_centre(pixel);
    const std::uint32_t ring = (pixel - cap) / (4 * n), place = (pixel - cap) % (4 * n);
    const double height = (2.0 * n - 2.0 * ring) / (3.0 * n);  // rings n + ring: y = 4/3 - 2i/3n
    const double shift = ring % 2 == 0 ? 0.5 : 0.0;
    return at(height, 1 - std::abs(height), (place + shift) / (4.0 * n));
  }

  /// The pixel that holds a unit direction.
  std::uint32_t pixel(const vec3& d) const {
    const glm::dvec3 v(d);
    const double turns = std::atan2(v.z, v.x) / (2 * std::numbers::pi);
    const double r2 = v.x * v.x + v.z * v.z;
    return pixel(v.y, r2 / (1 + std::abs(v.y)), turns);
  }

  /// The same from the height y in [-1, 1], 1 - |y| (which the caller may know with more digits), and the
  /// azimuth in turns, of any whole part.
  std::uint32_t pixel(double height, double depth, double turns) const {
    const double quarters = 4 * (turns - std::floor(turns));
    return std::abs(height) <= 2.0 / 3 ? belt_pixel(height, quarters) : cap_pixel(height, depth, quarters);
  }

 private:
  static constexpr std::uint32_t square(std::uint32_t x) { return x * x; }

  /// A direction of that height, 1 - |height| and azimuth in turns.
  static vec3 at(double height, double depth, double turns) {
    const double r = std::sqrt(depth * (2 - depth)), azimuth = 2 * std::numbers::pi * turns;
    return vec3(glm::dvec3(r * std::cos(azimuth), height, r * std::sin(azimuth)));
  }

  /// Pixel `place`, counted from the pole, of a polar cap: ring i holds 4i pixels and 1 - |y| = i²/3n².
  vec3 cap_centre(std::uint32_t place, double sign) const {
    const std::uint32_t ring = cap_ring(place), first = 2 * ring * (ring - 1);
    const double depth = double(square(ring)) / (3.0 * square(std::uint32_t(nside_)));
    return at(sign * (1 - depth), depth, (place - first + 0.5) / (4.0 * ring));
  }

  vec3 south_centre(std::uint32_t pixel) const {
    const std::uint32_t from_pole = pixel_count() - 1 - pixel, ring = cap_ring(from_pole);
    const std::uint32_t first = 2 * ring * (ring - 1);
    return cap_centre(first + (4 * ring - 1 - (from_pole - first)), -1);  // azimuth grows on both caps
  }

  /// Ring of the pixel in place p of a cap, from 1: the i with 2i(i - 1) <= p < 2i(i + 1).
  static std::uint32_t cap_ring(std::uint32_t place) {
    std::uint32_t ring = std::uint32_t((1 + std::sqrt(1.0 + 2.0 * place)) / 2);
    while (2 * ring * (ring - 1) > place) --ring;
    while (2 * ring * (ring + 1) <= place) ++ring;
    return ring;
  }

  /// Pixels between the caps lie between rising and falling lines of y against azimuth (section 5.2).
  std::uint32_t belt_pixel(double height, double quarters) const {
    const double across = nside_ * (0.5 + quarters), along = 0.75 * nside_ * height;
    const int falling = int(std::floor(across - along)), rising = int(std::floor(across + along));
    const int ring = std::clamp(nside_ + 1 + falling - rising, 1, 2 * nside_ + 1);  // from 1 at 4/3 - 2/3
    const int shift = ring % 2 == 0 ? 1 : 0, length = 4 * nside_;
    const int place = ((falling + rising - nside_ + shift + 1) / 2 + length) % length;
    return std::uint32_t(2 * nside_ * (nside_ - 1) + (ring - 1) * length + place);
  }

  std::uint32_t cap_pixel(double height, double depth, double quarters) const {
    const double part = quarters - std::floor(quarters), scale = nside_ * std::sqrt(3 * depth);
    const int ring = std::clamp(int(part * scale) + int((1 - part) * scale) + 1, 1, nside_);
    const int place = int(quarters * ring) % (4 * ring), first = 2 * ring * (ring - 1);
    if (height > 0) return std::uint32_t(first + place);
    return pixel_count() - std::uint32_t(first + 4 * ring) + std::uint32_t(place);
  }

  int nside_;
};

/// The centres of all pixels, in their order.
inline std::vector<vec3> healpix_centres(int nside) {
  const Healpix grid(nside);
  std::vector<vec3> centres(grid.pixel_count());
  for (std::uint32_t i = 0; i < grid.pixel_count(); ++i) centres[i] = grid.centre(i);
  return centres;
}

}  // namespace coppice
