// Light that goes to and fro between samples: from direct to indirect irradiance.
#pragma once

#include <coppice/transfer/transport.hpp>
//
#include <cmath>

namespace coppice {

struct InterreflectionOptions {
  std::uint32_t bounces = 8;  ///< at most: 4 to 8 with a tail; without, bright rooms need 12 to 20
  /// A sample: stands for the bounces that follow the last one, from interreflection_tail() for as many
  /// bounces; empty: they are left out. Not with a tolerance.
  std::span<const vec3> tail = {};
  /// Ends once a bounce adds nowhere more than this share of the greatest sum; 0: never early.
  float tolerance = 0;
};

/// The samples' albedos.
inline std::vector<vec3> albedos_of(std::span<const SurfaceSample> samples) {
  std::vector<vec3> albedos;
  albedos.reserve(samples.size());
  for (const SurfaceSample& sample : samples) albedos.push_back(sample.colour);
  return albedos;
}

namespace detail {

/// Turns irradiance into radiosity: element (i, 3v + c) by channel c of albedo i.
inline void reflect(std::span<const vec3> albedos, std::size_t begin, std::size_t end, Rows& rows) {
  for (std::size_t i = begin; i < end; ++i) {
    float* row = rows.values.data() + i * rows.width;
    for (std::size_t k = 0; k < rows.width; k += 3)
      for (int c = 0; c < 3; ++c) row[k + std::size_t(c)] *= albedos[i][c];
  }
}

/// What a bounce added, and what there is now: the greatest of each, by magnitude. Not a number wins.
struct Magnitudes {
  float added = 0, sum = 0;

  void include(float new_added, float new_sum) {
    if (!(std::abs(new_added) <= added)) added = std::abs(new_added);
    if (!(std::abs(new_sum) <= sum)) sum = std::abs(new_sum);
  }
};

/// sum += added; the magnitudes of each row.
template <Executor E>
Magnitudes accumulate(const Rows& added, const E& executor, Rows& sum) {
  std::vector<Magnitudes> of_rows(sum.count());
  executor(sum.count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = i * sum.width; k < (i + 1) * sum.width; ++k) {
        sum.values[k] += added.values[k];
        of_rows[i].include(added.values[k], sum.values[k]);
      }
  });
  Magnitudes all;
  for (const Magnitudes& row : of_rows) all.include(row.added, row.sum);
  return all;
}

/// sum += tail · last, channel by channel.
template <Executor E>
void add_tail(std::span<const vec3> tail, const Rows& last, const E& executor, Rows& sum) {
  executor(sum.count(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = 0; k < sum.width; ++k) sum[i][k] += tail[i][int(k % 3)] * last[i][k];
  });
}

/// Light that falls on all samples alike.
inline Rows even_light(std::size_t count) {
  Rows rows(count, 3);
  std::ranges::fill(rows.values, 1.0f);
  return rows;
}

}  // namespace detail

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// The indirect irradiance that direct irradiance E0 causes: Σ_{k=1..bounces} (T·ρ)^k E0, the Neumann series
/// of PCA Eq. 3-4 without its first term, so that S holds no identity: direct light is drawn sharp and apart.
/// Many right-hand sides at once: element (i, 3v + c) of `direct` and of the result is sample i, right-hand
/// side v, channel c; they may be negative (basis vectors). Linear in `direct`. After b bounces at most
/// ρ^b/(1-ρ) of the greatest irradiance is missing, with ρ the greatest albedo; albedo 1 in a closed room
/// grows by a term a bounce. options.tail stands for these. The same for any executor. Cost: a pass over T a
/// bounce. Preconditions: widths a multiple of 3; as many rows and albedos, and factors of the tail if any,
/// as T has rows.
template <Executor E>
Rows interreflect(const Transport& transport, std::span<const vec3> albedos, const Rows& direct,
                  const E& executor, const InterreflectionOptions& options = {}) {
  COPPICE_ASSERT(direct.width % 3 == 0 && albedos.size() == transport.size());
  COPPICE_ASSERT(direct.values.size() == transport.size() * direct.width);
  COPPICE_ASSERT(options.tail.empty() || (options.tail.size() == albedos.size() && options.tolerance == 0));
  Rows sum(transport.size(), direct.width), radiosity = direct, received;
  for (std::uint32_t bounce = 0; bounce < options.bounces; ++bounce) {
    executor(transport.size(), 256,
             [&](std::size_t begin, std::size_t end) { detail::reflect(albedos, begin, end, radiosity); });
    apply(transport, radiosity, executor, received);
    const detail::Magnitudes now = detail::accumulate(received, executor, sum);
    if (options.tolerance > 0 && now.added <= options.tolerance * now.sum) break;
    std::swap(radiosity, received);
  }
  if (!options.tail.empty() && options.bounces > 0) detail::add_tail(options.tail, radiosity, executor, sum);
  return sum;
}

/// For each sample and channel the factor by which the last of `bounces` bounces is to be multiplied to stand
/// for all that follow, up to bounce `last`: their ratio where even light falls on all samples. By then
/// light has spread, so that the ratio hardly depends on where it came from; rooms of different colours each
/// have their own. Linear in the light, so basis vectors may use it. 0 where nothing arrives. Finite for
/// white closed rooms too, which then have `last` bounces. Cost: `last` passes over T. Preconditions: as for
/// interreflect; 1 <= bounces <= last.
template <Executor E>
std::vector<vec3> interreflection_tail(const Transport& transport, std::span<const vec3> albedos,
                                       const E& executor, std::uint32_t bounces, std::uint32_t last = 40) {
  COPPICE_ASSERT(bounces >= 1 && bounces <= last);
  Rows light = detail::even_light(transport.size()), received;
  const auto bounce = [&] {
    detail::reflect(albedos, 0, transport.size(), light);
    apply(transport, light, executor, received);
    std::swap(light, received);
  };
  for (std::uint32_t k = 0; k < bounces; ++k) bounce();
  const Rows reached = light;
  Rows rest(transport.size(), 3);
  for (std::uint32_t k = bounces; k < last; ++k) {
    bounce();
    detail::accumulate(light, executor, rest);
  }
  std::vector<vec3> tail(transport.size(), vec3(0));
  for (std::size_t i = 0; i < tail.size(); ++i)
    for (int c = 0; c < 3; ++c)
      if (reached[i][std::size_t(c)] != 0) tail[i][c] = rest[i][std::size_t(c)] / reached[i][std::size_t(c)];
  return tail;
}

}  // namespace coppice::inline HWY_NAMESPACE
