// Positions for lights, anywhere that particles have flown.
#pragma once

#include <coppice/transfer/particles.hpp>

namespace coppice {

namespace detail {

/// Metres of a flight that keep `clearance` from its ends on surfaces.
inline double free_length(const Flight& flight, float clearance, bool sky) {
  if (flight.from_sky && !sky) return 0;
  return std::max(0.0, double(length(flight.to - flight.from)) - 2 * double(clearance));
}

}  // namespace detail

/// Draws `count` positions uniformly from the free space that can be reached: after some reflections as many
/// metres are flown through each cubic metre. `clearance` (m) is kept along the flight from both its ends, so
/// walls beside the flight may be nearer. In scenes without a roof only flights between surfaces count, if
/// there are any: that is the space between the objects. Draws are independent; the first n are the same
/// for every count. None where no flight is longer than twice the clearance.
inline std::vector<vec3> free_positions(std::span<const Flight> flights, std::size_t count,
                                        std::uint64_t seed, float clearance = 0.1f) {
  const bool sky = std::ranges::all_of(flights, [](const Flight& f) { return f.from_sky; });
  std::vector<double> sums;
  double total = 0;
  for (const Flight& f : flights) sums.push_back(total += detail::free_length(f, clearance, sky));
  std::vector<vec3> positions;
  if (!(total > 0)) return positions;
  Random random(seed);
  while (positions.size() < count) {
    const double at = total * (double(random.uniform()) + double(random.uniform()) * 0x1p-24);
    const auto i = std::size_t(std::ranges::upper_bound(sums, at) - sums.begin());
    const float along = random.uniform();
    if (i >= flights.size()) continue;
    const Flight& f = flights[i];
    const float whole = length(f.to - f.from);
    positions.push_back(glm::mix(f.from, f.to, (clearance + along * (whole - 2 * clearance)) / whole));
  }
  return positions;
}

}  // namespace coppice
