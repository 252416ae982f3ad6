// The shading kernels for the instructions for which the including file is compiled.
#pragma once

#include <coppice/relight/brute_force.hpp>
#include <coppice/relight/shade_faces.hpp>
#include <coppice/relight/shading_kernels.hpp>

namespace coppice::inline HWY_NAMESPACE {

template <Quantised Value>
const ShadingKernels<Value>& compiled_kernels() {
  static const ShadingKernels<Value> kernels{
      hwy::TargetName(HWY_TARGET), Lanes::width, &shade_faces<Value>, &shade_faces<LocalLights, Value>,
      [](Skip skip, const ShadingBuffer& buffer, std::span<const std::uint64_t> bits,
         std::uint32_t leaf_count, const DenseLights& lights, std::size_t begin, std::size_t end,
         std::span<vec3> radiance) {
        const auto kernel = skip == Skip::nothing ? shade_faces_brute_force<Skip::nothing>
                                                  : shade_faces_brute_force<Skip::unseen>;
        kernel(buffer, bits, leaf_count, lights, begin, end, radiance);
      }};
  return kernels;
}

}  // namespace coppice::inline HWY_NAMESPACE
