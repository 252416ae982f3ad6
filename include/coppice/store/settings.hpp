// What a store was made from, as text.
#pragma once

#include <string>
#include <vector>

namespace coppice {

/// Something that decides what a store holds: a fingerprint of the scene, σ, the camera. No NUL in either
/// text.
struct Setting {
  std::string key, value;

  friend bool operator==(const Setting&, const Setting&) = default;
};

/// In the order in which a reader should meet them; each key once.
using Settings = std::vector<Setting>;

/// The first difference as the end of a sentence about the store, "was made with sigma 2, now it is 3"; empty
/// where both agree. Settings are compared by key, in the order of `current`, then of `stored`. One line,
/// whatever a file says.
std::string first_difference(const Settings& stored, const Settings& current);

}  // namespace coppice
