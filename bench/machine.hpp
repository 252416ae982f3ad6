// What a report names: the machine that it was measured on.
#pragma once

#include <fstream>
#include <string>

namespace coppice::bench {

/// The name that Linux gives to the processor.
inline std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

}  // namespace coppice::bench
