// The loops over faces as functions that a program can choose at run time.
#pragma once

#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/dense_lights.hpp>
#include <coppice/relight/lobes.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <cstdint>
#include <span>

namespace coppice {

/// shade_faces and shade_faces_brute_force, compiled for one set of instructions.
template <Quantised Value>
struct ShadingKernels {
  const char* instructions;  ///< name of the set, as Highway gives it
  std::size_t width;         ///< floats a register
  void (*shade_faces)(const ShadingBuffer&, const MaskedCuts<Value>&, const FrameLighting&,
                      const LobeOptions&, std::size_t begin, std::size_t end, std::span<vec3> radiance,
                      std::span<std::uint32_t> cluster_count);
  void (*shade_faces_locally)(const ShadingBuffer&, const MaskedCuts<Value>&, std::span<const float> scales,
                              const LightingOf<LocalLightNode>&, const LobeOptions&, std::size_t begin,
                              std::size_t end, std::span<vec3> radiance,
                              std::span<std::uint32_t> cluster_count);  ///< by lights in the scene
  void (*brute_force)(Skip, const ShadingBuffer&, std::span<const std::uint64_t> bits,
                      std::uint32_t leaf_count, const DenseLights&, std::size_t begin, std::size_t end,
                      std::span<vec3> radiance);
};

}  // namespace coppice
