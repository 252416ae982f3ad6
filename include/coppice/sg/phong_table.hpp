// What brdf_lobes looks up for Phong: two Gaussians for each exponent. Printed by scripts/fit_gaussians.cpp,
// which says what is fitted.
#pragma once

#include <coppice/sg/brdf_table.hpp>

namespace coppice::detail {

/// At exponents 1/(i/8)², i = 0 … 8.
inline constexpr PhongFit phong_power[9] = {
    {0.003569f, -5.271f}, {0.05218f, -4.76f}, {0.1799f, -3.772f}, {0.3454f, -2.929f}, {0.5286f, -2.301f},
    {0.7181f, -1.838f},   {0.907f, -1.493f},  {1.091f, -1.23f},   {1.267f, -1.027f},
};

}  // namespace coppice::detail
