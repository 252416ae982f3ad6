// What a rigid object hides from the points around it: visibility cuts at samples in its own frame.
#pragma once

#include <coppice/relight/field_samples.hpp>
#include <coppice/relight/visibility_cuts.hpp>

namespace coppice {

/// Visibility of distant lights past an object, at samples around it (Cuts section 4.2; shadow fields, Zhou
/// et al. 2005). Between samples visibility is interpolated, so that its shadows are as sharp as the samples
/// are dense.
struct ShadowField {
  FieldSamples samples;
  MaskedCuts<std::uint8_t> cuts;    ///< a sample; over the directions of the lights in the object's frame
  std::vector<std::uint8_t> blind;  ///< a sample: it sees nothing at all, for it lies inside the object

  /// The samples around a point (in the object's frame) that see anything. Where all of them are blind they
  /// count as they are.
  SampleBlend locate(const vec3& point) const {
    const SampleBlend all = coppice::locate(samples, point);
    SampleBlend seeing;
    float sum = 0;
    for (std::uint32_t i = 0; i < all.count; ++i) {
      if (blind[all.samples[i]]) continue;
      seeing.add(all.samples[i], all.weights[i]);
      sum += all.weights[i];
    }
    if (seeing.count == 0) return all;
    for (std::uint32_t i = 0; i < seeing.count; ++i) seeing.weights[i] /= sum;
    return seeing;
  }

  /// True where all samples of a blend see every light.
  bool is_clear(const SampleBlend& blend) const {
    for (std::uint32_t i = 0; i < blend.count; ++i) {
      const std::uint32_t s = blend.samples[i];
      if (cuts.piece_count(s) != 1 || cuts.values()[cuts.first_value()[s]] != 255) return false;
    }
    return true;
  }
};

/// Traces the field of whatever `occluder` holds. `leaf_lights`: a direction a leaf of the tree. All lights
/// count alike at a sample, since it has no normal: options.weight is not read.
template <Occluder O, Executor E>
ShadowField precompute_field(const O& occluder, const LightTree& tree, const DirectionPackets& leaf_lights,
                             const FieldSamples& samples, VisibilityCutOptions options, const E& executor,
                             const Progress& progress = {}) {
  std::vector<Receiver> receivers;
  for (const vec3& p : positions_of(samples)) {
    receivers.emplace_back();
    receivers.back().position = p;
    receivers.back().normal = vec3(0);  // with a horizon below 0: all directions
    receivers.back().horizon = -1;
  }
  options.weight = CutWeight::uniform;
  auto stored = precompute_visibility<std::uint8_t>(occluder, tree, leaf_lights, receivers,
                                                    std::span(&options, 1), false, executor, progress);
  ShadowField field{samples, std::move(stored.cuts[0]), {}};
  for (std::size_t s = 0; s < field.cuts.size(); ++s)
    field.blind.push_back(field.cuts.piece_count(s) == 1 &&
                          field.cuts.values()[field.cuts.first_value()[s]] == 0);
  return field;
}

}  // namespace coppice
