// The trade of glossy_vpls: nodes, time and error over its knobs.
#pragma once

namespace coppice::program {

/// The program `trade glossy_vpls`: its command line, from its name on. Returns the exit code.
int sweep_vpls(int argc, char** argv);

}  // namespace coppice::program
