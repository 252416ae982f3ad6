// The shading kernels for several instruction sets: one program that is fast on every processor.
#pragma once

#include <coppice/relight/shading_kernels.hpp>
#include <span>

namespace coppice {

/// Sets of instructions; a processor with one of them has those before it.
enum class InstructionSet {
  baseline,  ///< those that the compiler's options name
  avx2,      ///< with FMA, BMI2 and F16C: 8 floats a register
  avx512     ///< with VL, DQ and BW: 16 floats a register
};

/// "baseline", "avx2" or "avx512".
const char* name(InstructionSet set);

/// The sets that this build holds and this processor runs, the best one last; baseline is always among them.
/// Outside of x86-64 it is the only one.
std::span<const InstructionSet> supported_instruction_sets();

/// The kernels for one set. Images of different sets differ by rounding alone; one set always gives the same
/// bits. Precondition: the set is among supported_instruction_sets().
template <Quantised Value>
const ShadingKernels<Value>& kernels_for(InstructionSet set);

/// The kernels for the best set of this processor.
template <Quantised Value>
const ShadingKernels<Value>& best_kernels() {
  return kernels_for<Value>(supported_instruction_sets().back());
}

}  // namespace coppice
