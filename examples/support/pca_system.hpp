// A room lit by lights that move through it, frame by frame.
#pragma once

#include <coppice/embree/threads.hpp>
#include <memory>
#include <support/pca_options.hpp>
#include <support/system.hpp>

namespace coppice::program {

/// The scene of the command line, at rest, under its lights. `parts` of a frame are "direct" and "indirect".
/// Its reference takes shadow rays from pixels and samples, and solves for the light between the samples
/// without any basis. Inputs outlive it.
std::unique_ptr<System> make_pca_system(const PcaSystemOptions& options, Inputs& in, const Threads& threads);

}  // namespace coppice::program
