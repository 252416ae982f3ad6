// Text from a printf format, and its parts.
#pragma once

#include <string>
#include <vector>

namespace coppice::program {

/// The text that printf would print.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

/// "a:b:c" as a, b and c; always one part at least.
std::vector<std::string> split_at_colons(const std::string& text);

}  // namespace coppice::program
