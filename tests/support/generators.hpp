// Seeded random cuts, lights and environments. The `any_` functions draw from RapidCheck and so shrink.
#pragma once

#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <coppice/core/random.hpp>
#include <coppice/cut/cut.hpp>
#include <coppice/light/environment.hpp>
#include <coppice/tree/metric.hpp>
#include <cstdint>
#include <numeric>
#include <type_traits>
#include <vector>

namespace test_support {

/// |a - b| <= relative · max(|a|, |b|).
inline bool close(long double a, long double b, double relative) {
  return std::abs(a - b) <= static_cast<long double>(relative) * std::max(std::abs(a), std::abs(b));
}

inline coppice::Random any_random() { return coppice::Random(*rc::gen::arbitrary<std::uint64_t>()); }

/// A power of two from 1 to 2^greatest_log2.
inline std::uint32_t any_leaf_count(int greatest_log2) {
  return 1u << *rc::gen::inRange(0, greatest_log2 + 1);
}

namespace detail {

inline void split_at_random(coppice::Random& random, coppice::LeafRange range, std::uint32_t granule,
                            float chance, std::vector<std::uint32_t>& ends) {
  if (range.size() <= granule || random.uniform() >= chance) {
    ends.push_back(range.end);
    return;
  }
  const std::uint32_t middle = range.begin + range.size() / 2;
  split_at_random(random, {range.begin, middle}, granule, chance, ends);
  split_at_random(random, {middle, range.end}, granule, chance, ends);
}

}  // namespace detail

/// Ends of a random cut: every node of more than `granule` leaves is split with this chance. 0: the root
/// alone.
inline std::vector<std::uint32_t> random_ends(coppice::Random& random, std::uint32_t leaf_count, float chance,
                                              std::uint32_t granule = 1) {
  std::vector<std::uint32_t> ends;
  if (leaf_count > 0) detail::split_at_random(random, {0, leaf_count}, granule, chance, ends);
  return ends;
}

/// Any value of an integer type; [-1, 1) of a floating one.
template <class Value>
Value random_value(coppice::Random& random) {
  if constexpr (std::is_floating_point_v<Value>)
    return Value(2 * random.uniform() - 1);
  else
    return Value(random.bits());
}

template <class Value>
coppice::Cut<Value> random_cut(coppice::Random& random, std::uint32_t leaf_count, float chance,
                               std::uint32_t granule = 1) {
  return coppice::cut_with_values(leaf_count, random_ends(random, leaf_count, chance, granule),
                                  [&](std::uint32_t) { return random_value<Value>(random); });
}

/// A cut that may be the root alone, every leaf, or anything between.
template <class Value>
coppice::Cut<Value> any_cut(coppice::Random& random, std::uint32_t leaf_count) {
  const int tenths = *rc::gen::inRange(0, 11);
  return random_cut<Value>(random, leaf_count, float(tenths) * 0.1f);
}

/// Numbers 0 … count - 1 in random order.
inline std::vector<std::uint32_t> shuffled(coppice::Random& random, std::uint32_t count) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  for (std::uint32_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

/// Lights in a box of 2 × 2 × 2 round the centre, with random normals.
inline std::vector<coppice::LightSample> scattered_lights(coppice::Random& random, std::uint32_t count,
                                                          const coppice::vec3& centre = coppice::vec3(0)) {
  std::vector<coppice::LightSample> lights(count);
  for (auto& light : lights) {
    const float x = random_value<float>(random), y = random_value<float>(random),
                z = random_value<float>(random);
    light = {centre + coppice::vec3(x, y, z), random.direction()};
  }
  return lights;
}

/// A map of independent random texels over nine orders of magnitude.
inline coppice::Image random_map(coppice::Random& random, int width, int height) {
  coppice::Image map(width, height);
  for (auto& pixel : map.pixels)
    for (int c = 0; c < 3; ++c) pixel[c] = std::exp(20 * random.uniform() - 10);
  return map;
}

}  // namespace test_support
