// The sum over all lights in SIMD: what an engineer would write without a tree. The baseline of every
// speed-up.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <bit>
#include <coppice/relight/dense_lights.hpp>
#include <coppice/relight/shade.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <coppice/relight/visibility.hpp>
#include <span>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

/// Radiance of one point from all lights, visibility interpolated between three rows of bits. With
/// Skip::unseen, registers of lights that none of the three receivers sees are left out.
template <Skip skip>
vec3 shade_brute_force(const ShadingPoint& point, const DenseLights& lights, std::span<const std::uint64_t> a,
                       std::span<const std::uint64_t> b, std::span<const std::uint64_t> c) {
  return with_brdf(point, [&](const auto& brdf) {
    using B = std::decay_t<decltype(brdf)>;
    constexpr std::uint64_t all =
        Lanes::width == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << Lanes::width) - 1;
    const LocalFrame frame(point);
    const Lanes w0 = point.weight_0, w1 = point.weight_1, w2 = 1 - point.weight_0 - point.weight_1;
    TermSums sums;
    for (std::size_t i = 0; i < lights.x.size(); i += Lanes::width) {
      const std::uint64_t va = (a[i / 64] >> (i % 64)) & all, vb = (b[i / 64] >> (i % 64)) & all,
                          vc = (c[i / 64] >> (i % 64)) & all;
      if (skip == Skip::unseen && (va | vb | vc) == 0) continue;
      const Lanes visibility =
          select(lane_mask(va), w0, 0.0f) + select(lane_mask(vb), w1, 0.0f) + select(lane_mask(vc), w2, 0.0f);
      const Lanes x = Lanes::load(&lights.x[i]), y = Lanes::load(&lights.y[i]), z = Lanes::load(&lights.z[i]);
      const auto terms =
          brdf(LocalFrame::along(frame.tangent, x, y, z), LocalFrame::along(frame.bitangent, x, y, z),
               LocalFrame::along(frame.normal, x, y, z));
      sums.add<B::terms>(terms, visibility, Lanes::load(&lights.red[i]), Lanes::load(&lights.green[i]),
                         Lanes::load(&lights.blue[i]));
    }
    return sums.colour(point);
  });
}

/// Brute force for the points of faces [begin, end). `bits` holds words_for_bits(leaf count) words a
/// receiver.
template <Skip skip>
void shade_faces_brute_force(const ShadingBuffer& buffer, std::span<const std::uint64_t> bits,
                             std::uint32_t leaf_count, const DenseLights& lights, std::size_t begin,
                             std::size_t end, std::span<vec3> radiance) {
  const std::size_t words = words_for_bits(leaf_count);
  const auto row = [&](std::uint32_t receiver) { return bits.subspan(receiver * words, words); };
  for (std::size_t f = begin; f < end; ++f) {
    const uvec3 r = buffer.faces[f].receivers;
    for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p)
      radiance[p] = shade_brute_force<skip>(buffer.points[p], lights, row(r.x), row(r.y), row(r.z));
  }
}

}  // namespace coppice::inline HWY_NAMESPACE
