#include <coppice/relight/compiled_kernels.hpp>

#include "kernel_tables.hpp"

namespace coppice {

KernelTables baseline_tables() {
  return {&compiled_kernels<std::uint8_t>(), &compiled_kernels<std::uint16_t>()};
}

}  // namespace coppice
