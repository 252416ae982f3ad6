#include "kernel_tables.hpp"

#if COPPICE_COMPILE_AVX512

#undef HWY_TARGET
#define HWY_TARGET HWY_AVX3
#include "kernels_of_target.hpp"

namespace coppice {

KernelTables avx512_tables() {
  return {&compiled_kernels<std::uint8_t>(), &compiled_kernels<std::uint16_t>()};
}

}  // namespace coppice

#endif
