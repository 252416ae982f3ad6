// The light of points through cones, before visibility and after.
#pragma once

#include <coppice/shared/cones.h>

#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <cstdint>
#include <span>
#include <vector>

namespace coppice {

/// One point's light before visibility.
struct LitCones {
  std::vector<LitCone> cones;
  vec3 untraced{0};            ///< radiance that has no cone: as much of it is visible as of the cones'
  std::uint32_t clusters = 0;  ///< at which the BRDF was evaluated

  vec3 unoccluded() const {
    vec3 sum = untraced;
    for (const LitCone& cone : cones) sum += cone.radiance;
    return sum;
  }
};

/// What remains of a point's light: Σ radiance · visibility, and of the untraced light the mean share.
inline vec3 visible_light(std::span<const LitCone> cones, std::span<const float> visibility,
                          const vec3& untraced) {
  vec3 sum(0);
  float seen = 0, total = 0;
  for (std::size_t i = 0; i < cones.size(); ++i) {
    sum += visibility[i] * cones[i].radiance;
    seen += visibility[i] * cones[i].luminance;
    total += cones[i].luminance;
  }
  return sum + untraced * (total > 0 ? seen / total : 1.0f);
}

/// The cones of many points, those of one point together: ConeReceiver::cones_end tells where they end.
struct ConeBatch {
  std::vector<ConeReceiver> receivers;
  std::vector<LitCone> cones;
  std::vector<SgShape> shapes;  ///< of the cones, for who traces them
  std::vector<vec3> untraced;   ///< by receiver
  std::size_t clusters = 0;

  std::uint32_t begin_of(std::size_t receiver) const {
    return receiver > 0 ? receivers[receiver - 1].cones_end : 0;
  }
};

/// Radiance by receiver once the visibility of each cone is known.
template <Executor E>
std::vector<vec3> visible_light(const ConeBatch& batch, std::span<const float> visibility,
                                const E& executor) {
  COPPICE_ASSERT(visibility.size() == batch.cones.size());
  std::vector<vec3> radiance(batch.receivers.size());
  executor(radiance.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t first = batch.begin_of(i), count = batch.receivers[i].cones_end - first;
      radiance[i] = visible_light(std::span(batch.cones).subspan(first, count),
                                  visibility.subspan(first, count), batch.untraced[i]);
    }
  });
  return radiance;
}

/// Places the cones of all receivers, whose cones_end is filled in: `make_placer()` gives an object for one
/// thread whose `place(i)` returns the LitCones of receiver i. Any split over threads gives the same batch.
template <class MakePlacer, Executor E>
ConeBatch place_cones(std::vector<ConeReceiver> receivers, MakePlacer&& make_placer, const E& executor) {
  constexpr std::size_t block = 256;
  const std::size_t blocks = (receivers.size() + block - 1) / block;
  std::vector<ConeBatch> parts(blocks);
  executor(blocks, 1, [&](std::size_t begin, std::size_t end) {
    auto placer = make_placer();
    for (std::size_t b = begin; b < end; ++b)
      for (std::size_t i = b * block; i < std::min(receivers.size(), (b + 1) * block); ++i) {
        const LitCones& lit = placer.place(i);
        parts[b].cones.insert(parts[b].cones.end(), lit.cones.begin(), lit.cones.end());
        parts[b].untraced.push_back(lit.untraced);
        parts[b].clusters += lit.clusters;
        receivers[i].cones_end = std::uint32_t(parts[b].cones.size());
      }
  });
  ConeBatch batch;
  batch.receivers = std::move(receivers);
  for (std::size_t b = 0; b < blocks; ++b) {
    const auto before = std::uint32_t(batch.cones.size());
    for (std::size_t i = 0; i < parts[b].untraced.size(); ++i)
      batch.receivers[b * block + i].cones_end += before;
    batch.cones.insert(batch.cones.end(), parts[b].cones.begin(), parts[b].cones.end());
    batch.untraced.insert(batch.untraced.end(), parts[b].untraced.begin(), parts[b].untraced.end());
    batch.clusters += parts[b].clusters;
  }
  for (const LitCone& cone : batch.cones) batch.shapes.push_back(cone.shape);
  return batch;
}

}  // namespace coppice
