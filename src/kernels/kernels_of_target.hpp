// compiled_kernels for the instructions of HWY_TARGET, which the including source has set.
//
// What does not touch registers is included first, and so is compiled as everywhere else: the linker keeps
// one copy of an inline function and gives it to the whole program, also where the processor is older. Code
// for the target lies in its own namespace. scripts/check_instructions.py looks for what breaks this rule.
#pragma once

#include <coppice/shared/layout.h>
#include <coppice/shared/node.h>
#include <hwy/contrib/math/math-inl.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <coppice/core/config.hpp>
#include <coppice/core/math.hpp>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/dense_lights.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <coppice/relight/lobes.hpp>
#include <coppice/relight/shading_buffer.hpp>
#include <coppice/relight/shading_kernels.hpp>
#include <coppice/relight/visibility.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
#include <vector>

HWY_BEFORE_NAMESPACE();
#include <coppice/relight/compiled_kernels.hpp>
HWY_AFTER_NAMESPACE();
