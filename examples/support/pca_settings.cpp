#include <support/pca_settings.hpp>
//
#include <charconv>
#include <coppice/core/error.hpp>
#include <support/text.hpp>
#include <vector>

namespace coppice::program {
namespace {

/// One part of a setting: WORD or KEY=VALUE.
struct Part {
  std::string key, value;

  explicit Part(const std::string& text) {
    const std::size_t equals = text.find('=');
    key = text.substr(0, equals);
    if (equals != std::string::npos) value = text.substr(equals);  // with its sign: "=5"
  }
  bool is_word(const char* word) const { return key == word && value.empty(); }

  /// KEY=NUMBER within a range; none for anything else.
  template <class Number>
  std::optional<Number> number(const char* wanted, Number least, Number most) const {
    if (key != wanted || value.size() < 2) return std::nullopt;
    return number_of<Number>(std::string_view(value).substr(1), least, most);
  }
  template <class Number>
  static std::optional<Number> number_of(std::string_view text, Number least, Number most) {
    Number x{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return x >= least && x <= most ? std::optional(x) : std::nullopt;
  }
};

constexpr std::size_t most_rank = 1024;

std::optional<int> bits_of(const Part& part) {
  const auto bits = part.number<int>("bits", 8, 16);
  return bits == 8 || bits == 16 ? bits : std::nullopt;
}

bool apply_to_lattice(const Part& part, RoomShadowOptions& o) {
  if (const auto points = part.number<std::size_t>("points", 8, std::size_t{1} << 20))
    o.lattice_points = *points;
  else if (const auto training = part.number<std::uint32_t>("training", 0, 64))
    o.training = *training;
  else if (part.is_word("smooth"))
    o.shadow = LatticeShadow::smooth;
  else
    return false;
  return true;
}

bool apply_to_depth(const Part& part, RoomShadowOptions& o) {
  if (const auto directions = part.number<std::uint32_t>("directions", 16, 16384))
    o.directions = *directions;
  else if (const auto intervals = part.number<int>("intervals", 0, 64))
    o.intervals = *intervals;
  else if (part.is_word("plain"))
    o.intervals = 0;
  else if (part.is_word("sphere"))
    o.dome = Dome::sphere;
  else
    return false;
  return true;
}

bool apply(const Part& part, RoomShadowOptions& o) {
  if (o.kind == RoomVisibility::rays) return false;
  if (const auto bits = bits_of(part)) {
    o.bits = *bits;
    return true;
  }
  return o.kind == RoomVisibility::lattice ? apply_to_lattice(part, o) : apply_to_depth(part, o);
}

bool apply(const Part& part, TransferSetting& s) {
  if (const auto patterns = part.number<std::size_t>("patterns", 1, most_rank))
    s.options.receiver_rank = *patterns;
  else if (const auto bits = bits_of(part))
    s.options.bits = *bits;
  else if (const auto share = part.number<double>("sparse", 0.0, 1.0))
    s.sparse = share;
  else if (part.is_word("no-mean") && s.options.basis == LightBasisKind::paper)
    s.mean = false;
  else
    return false;
  return true;
}

}  // namespace

VisibilitySetting parse_visibility(const std::string& text, const RoomShadowOptions& base) {
  const auto refuse = [&]() -> InputError {
    return {"--visibility", "'" + text + "' is no way to know shadows",
            "write KIND:RANK and what follows it, as in lattice:20:points=8000, depth:50:plain or rays"};
  };
  const std::vector<std::string> parts = split_at_colons(text);
  VisibilitySetting setting{text, base};
  const auto kind = choice_of(room_visibility_words, parts[0]);
  if (!kind) throw refuse();
  setting.options.kind = *kind, setting.options.rank = 0;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto rank = i == 1 && *kind != RoomVisibility::rays
                          ? Part::number_of<std::size_t>(parts[i], 1, most_rank)
                          : std::nullopt;
    if (rank)
      setting.options.rank = *rank;
    else if (!apply(Part(parts[i]), setting.options))
      throw refuse();
  }
  return setting;
}

TransferSetting parse_transfer(const std::string& text, const RoomTransferOptions& base) {
  const auto refuse = [&]() -> InputError {
    return {"--basis", "'" + text + "' is no way to transfer light",
            "write BASIS:RANK and what follows it, as in transport:20:patterns=30 or paper:10:no-mean"};
  };
  const std::vector<std::string> parts = split_at_colons(text);
  TransferSetting setting{.text = text, .options = base};
  const auto basis = choice_of(light_basis_words, parts[0]);
  const auto rank = parts.size() > 1 ? Part::number_of<std::size_t>(parts[1], 1, most_rank) : std::nullopt;
  if (!basis || !rank) throw refuse();
  setting.options.basis = *basis, setting.options.rank = *rank;
  for (std::size_t i = 2; i < parts.size(); ++i)
    if (!apply(Part(parts[i]), setting)) throw refuse();
  return setting;
}

}  // namespace coppice::program
