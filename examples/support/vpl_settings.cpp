#include <coppice/core/error.hpp>
#include <support/text.hpp>
#include <support/vpl_settings.hpp>

namespace coppice::program {

namespace {

float number(const std::string& option, const std::string& text) {
  try {
    std::size_t end = 0;
    const float value = std::stof(text, &end);
    if (end == text.size() && std::isfinite(value) && value >= 0) return value;
  } catch (const std::logic_error&) {
  }
  throw InputError(option, "'" + text + "' is not a number of at least 0", "write bound:0.01 or the like");
}

}  // namespace

GatherSetting parse_gather(const std::string& text) {
  std::vector<std::string> parts = split_at_colons(text);
  GatherSetting s{.name = text};
  const auto take = [&](const std::string& word) { return std::erase(parts, word) > 0; };
  if (take("kd")) s.tree.clustering = VplClustering::kd;
  if (take("lengths")) s.tree.clustering = VplClustering::lengths;
  if (take("uniform")) s.tree.filter = VplFilter::uniform;
  const bool is_min_max = parts[0] == "min-max";
  if (parts.size() != (is_min_max ? 4 : 2))
    throw InputError("--gather", "'" + text + "' is not KIND:THRESHOLD", "write bound:0.01 or the like");
  s.threshold = number("--gather", parts.back());
  if (is_min_max) s.min_max = {number("--gather", parts[1]), number("--gather", parts[2])};
  if (is_min_max || parts[0] == "angle")
    s.criterion = Criterion::angle;
  else if (parts[0] == "traced")
    s.traced = VplChoice::contribution;
  else if (parts[0] == "energy")
    s.traced = VplChoice::energy;
  else if (parts[0] != "bound")
    throw InputError("--gather", "'" + parts[0] + "' is no kind",
                     "use bound, angle, min-max, traced or energy");
  if (s.criterion == Criterion::angle && !(s.threshold > 0 && s.threshold < 6))
    throw InputError("--gather", "'" + text + "' has no solid angle between 0 and 6", "write angle:0.02");
  return s;
}

AdaptiveOptions parse_pixels(const std::string& text, float diagonal) {
  const std::vector<std::string> parts = split_at_colons(text);
  if (parts.size() != 2)
    throw InputError("--pixels", "'" + text + "' is not KIND:VALUE", "write relative:0.07");
  const float value = number("--pixels", parts[1]);
  AdaptiveOptions o;
  if (parts[0] == "paper")
    o = paper_sampling(diagonal);
  else if (parts[0] == "uniform" && (value == 2 || value == 4 || value == 8))
    return uniform_sampling(int(value));
  else if (parts[0] != "relative")
    throw InputError("--pixels", "'" + text + "' is no kind",
                     "use relative:EPSILON, paper:EPSILON or uniform:2, 4, 8");
  o.epsilon = value;
  return o;
}

}  // namespace coppice::program
