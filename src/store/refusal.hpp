// How the layers below the public functions, which see bytes only, tell of bad input.
#pragma once

#include <coppice/core/error.hpp>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace coppice::store {

struct Refusal : std::runtime_error {
  explicit Refusal(const std::string& problem, std::string advice = "remove the file and compute it again")
      : std::runtime_error(problem), remedy(std::move(advice)) {}
  std::string remedy;
};

/// The text with control characters, line ends among them, replaced by '?' and cut to 200 bytes.
inline std::string one_line(std::string text) {
  constexpr std::size_t longest = 200;
  if (text.size() > longest) text = text.substr(0, longest) + "...";
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

/// body(), with whatever it throws turned into an InputError that names the file.
template <class Body>
auto naming(const std::filesystem::path& path, Body&& body) {
  const auto error = [&](const std::string& problem, const std::string& remedy) {
    return InputError(path.empty() ? "(no file name)" : one_line(path.string()), one_line(problem), remedy);
  };
  try {
    return body();
  } catch (const Refusal& refusal) {
    throw error(refusal.what(), refusal.remedy);
  } catch (const std::bad_alloc&) {
    throw error("needs more memory than there is", "use a machine with more, or fewer receivers");
  } catch (const std::length_error&) {
    throw error("needs more memory than can be", "remove the file and compute it again");
  }
}

}  // namespace coppice::store
