// Measures whole images of which some pixels are gathered and the others interpolated.
#pragma once

#include <support/vpl_study.hpp>

namespace coppice::program {

/// One way to choose pixels.
struct PixelMeasurement {
  GatherMeasurement gather;  ///< nodes by gathered pixel, the rest by covered one
  double share = 0;          ///< of the covered pixels that were gathered
  double psnr = 0;           ///< dB, against the image of which all are gathered, both as previews show them
};

/// For each way. `reference`: the sum over all VPLs by point. Times are medians of `repeat` runs of one
/// thread.
std::vector<PixelMeasurement> measure_pixels(const VplSubject& subject, const VplTree& tree,
                                             const GatherSetting& setting, const EmbreeTracer& tracer,
                                             std::span<const AdaptiveOptions> ways,
                                             std::span<const vec3> reference, int repeat);

}  // namespace coppice::program
