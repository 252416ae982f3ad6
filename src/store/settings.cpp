#include <algorithm>
#include <coppice/store/settings.hpp>

#include "refusal.hpp"

namespace coppice {
namespace {

const Setting* find(const Settings& settings, const std::string& key) {
  const auto found = std::ranges::find(settings, key, &Setting::key);
  return found == settings.end() ? nullptr : &*found;
}

}  // namespace

std::string first_difference(const Settings& stored, const Settings& current) {
  using store::one_line;
  for (const Setting& now : current) {
    const Setting* then = find(stored, now.key);
    if (!then) return one_line("was made without " + now.key + ", now it is " + now.value);
    if (then->value != now.value)
      return one_line("was made with " + now.key + " " + then->value + ", now it is " + now.value);
  }
  for (const Setting& then : stored)
    if (!find(current, then.key))
      return one_line("was made with " + then.key + " " + then.value + ", now there is none");
  return "";
}

}  // namespace coppice
