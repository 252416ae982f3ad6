#include <hwy/targets.h>

#include <algorithm>
#include <concepts>
#include <coppice/core/config.hpp>
#include <coppice/kernels/kernels.hpp>

#include "kernel_tables.hpp"

namespace coppice {
namespace {

constexpr InstructionSet all_sets[] = {InstructionSet::baseline, InstructionSet::avx2,
                                       InstructionSet::avx512};

std::size_t count_supported() {
  [[maybe_unused]] const auto targets = hwy::SupportedTargets();
#if COPPICE_COMPILE_AVX512
  if (targets & HWY_AVX3) return 3;
#endif
#if COPPICE_COMPILE_AVX2
  if (targets & HWY_AVX2) return 2;
#endif
  return 1;
}

[[maybe_unused]] bool is_supported(InstructionSet set) {
  return std::ranges::count(supported_instruction_sets(), set) == 1;
}

KernelTables tables_for(InstructionSet set) {
#if COPPICE_COMPILE_AVX512
  if (set == InstructionSet::avx512) return avx512_tables();
#endif
#if COPPICE_COMPILE_AVX2
  if (set == InstructionSet::avx2) return avx2_tables();
#endif
  return baseline_tables();
}

}  // namespace

const char* name(InstructionSet set) {
  static constexpr const char* names[] = {"baseline", "avx2", "avx512"};
  return names[std::size_t(set)];
}

std::span<const InstructionSet> supported_instruction_sets() {
  return std::span(all_sets).first(count_supported());
}

template <Quantised Value>
const ShadingKernels<Value>& kernels_for(InstructionSet set) {
  COPPICE_ASSERT(is_supported(set));
  const KernelTables tables = tables_for(set);
  if constexpr (std::same_as<Value, std::uint8_t>)
    return *tables.bytes;
  else
    return *tables.words;
}

template const ShadingKernels<std::uint8_t>& kernels_for(InstructionSet);
template const ShadingKernels<std::uint16_t>& kernels_for(InstructionSet);

}  // namespace coppice
