// A scene lit by VPLs, frame by frame.
#pragma once

#include <coppice/embree/threads.hpp>
#include <memory>
#include <support/system.hpp>
#include <support/vpl_options.hpp>

namespace coppice::program {

/// The scene of the command line as VPLs light it. `parts` of a frame are the direct light, the light of the
/// VPLs ("indirect"), and the steps of the grids at which pixels were gathered ("sampled", 0: interpolated).
/// Its reference is the same light with every VPL for itself at every pixel. Inputs outlive it.
std::unique_ptr<System> make_vpl_system(const VplSystemOptions& options, Inputs& in, const Threads& threads);

}  // namespace coppice::program
