// The kernels of each instruction set, as the sources compiled for them hand them out.
#pragma once

#include <hwy/detect_targets.h>

#include <coppice/relight/shading_kernels.hpp>

#define COPPICE_COMPILE_AVX2 (HWY_ARCH_X86 && HWY_ENABLED(HWY_AVX2) != 0)
#define COPPICE_COMPILE_AVX512 (HWY_ARCH_X86 && HWY_ENABLED(HWY_AVX3) != 0)

namespace coppice {

struct KernelTables {
  const ShadingKernels<std::uint8_t>* bytes;
  const ShadingKernels<std::uint16_t>* words;
};

KernelTables baseline_tables();
/// Precondition of these two: the processor has the instructions.
KernelTables avx2_tables();
KernelTables avx512_tables();

}  // namespace coppice
