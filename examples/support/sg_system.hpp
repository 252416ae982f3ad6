// A scene lit by an environment through spherical Gaussians, frame by frame.
#pragma once

#include <coppice/embree/threads.hpp>
#include <memory>
#include <support/sg_options.hpp>
#include <support/system.hpp>

namespace coppice::program {

/// The scene of the command line, its materials and the map, all of which may change with each frame. `parts`
/// of a frame are the light without shadows ("unoccluded"). Its reference is the sum over the cells of the
/// sphere and every texel of a peak, a shadow ray each. Inputs outlive it.
std::unique_ptr<System> make_sg_system(const SgSystemOptions& options, Inputs& in, const Threads& threads);

}  // namespace coppice::program
