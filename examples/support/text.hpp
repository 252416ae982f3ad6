// Text from a printf format.
#pragma once

#include <string>

namespace coppice::program {

/// The text that printf would print.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

}  // namespace coppice::program
