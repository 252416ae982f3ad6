#include <charconv>
#include <coppice/core/error.hpp>
#include <sstream>
#include <support/knobs.hpp>
#include <support/text.hpp>

namespace coppice::program {

namespace {

/// Fields between colons; an empty last one counts.
std::vector<std::string> fields_of(const std::string& text) {
  std::vector<std::string> fields;
  std::istringstream stream(text + ":");
  for (std::string field; std::getline(stream, field, ':');) fields.push_back(field);
  return fields;
}

/// The text as a number, where all of it is one and lies in [low, high].
template <class Number>
std::optional<Number> number_in(const std::string& text, Number low, Number high) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  if (!is_number || !(number >= low && number <= high)) return std::nullopt;
  return number;
}

}  // namespace

std::vector<Knobs> combinations(const KnobRanges& ranges) {
  std::vector<Knobs> all;
  for (const CutKind& cuts : ranges.cuts)
    for (const double sigma : ranges.sigmas)
      for (const std::size_t nodes : ranges.sizes)
        for (const Lobes lobes : ranges.lobes) all.push_back({sigma, nodes, cuts, lobes});
  return all;
}

Knobs parse_knobs(const std::string& text) {
  const auto fields = fields_of(text);
  const auto choice = [&](std::size_t field, const auto& words, auto otherwise) {
    return field < fields.size() ? choice_of(words, fields[field]) : std::optional(otherwise);
  };
  const auto sigma = number_in(fields[0], 0.0, max_sigma);
  const auto nodes = fields.size() > 1 ? number_in(fields[1], std::size_t{1}, max_nodes) : std::nullopt;
  const auto cuts = choice(2, cut_kind_words, Knobs{}.cuts);
  const auto lobes = choice(3, lobes_words, Knobs{}.lobes);
  if (!sigma || !nodes || !cuts || !lobes || fields.size() > 4)
    throw InputError("--points " + text, "is not SIGMA:SIZE[:CUTS[:LOBES]]",
                     "write for example 2:64 or 2:64:cosine-optimal:refined");
  return {*sigma, *nodes, *cuts, *lobes};
}

std::string file_suffix(const Knobs& k) {
  return formatted("sigma%g_%zu_", k.sigma, k.nodes) + word_of(cut_kind_words, k.cuts) + "_" +
         word_of(lobes_words, k.lobes);
}

}  // namespace coppice::program
