// The trade of sg_relighting: cones, time and error over its knobs.
#pragma once

namespace coppice::program {

/// The program `trade sg_relighting`: its command line, from its name on. Returns the exit code.
int sweep_gaussians(int argc, char** argv);

}  // namespace coppice::program
