// The trade of pca_transfer: bytes, time and error of its bases on lights that they were not made for.
#pragma once

namespace coppice::program {

/// The program `trade pca_transfer`: its command line, from its name on. Returns the exit code.
int sweep_pca(int argc, char** argv);

}  // namespace coppice::program
