// How the decoders, which see bytes only, tell of bad input; the reader adds the file's name.
#pragma once

#include <coppice/core/error.hpp>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

namespace coppice::exr {

struct Refusal : std::runtime_error {
  explicit Refusal(const std::string& problem, std::string advice = "write or fetch the file again")
      : std::runtime_error(problem), remedy(std::move(advice)) {}
  std::string remedy;
};

/// The text with control characters, line ends among them, replaced by '?': an error is one line.
inline std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

inline InputError file_error(const std::filesystem::path& path, const std::string& problem,
                             std::string remedy) {
  const std::string name = path.empty() ? "(no file name)" : path.string();
  return InputError(one_line(name), one_line(problem), std::move(remedy));
}

/// body(), with whatever it throws turned into an InputError that names the file; `failure` says what an
/// exception of a library means.
template <class Body>
auto naming(const std::filesystem::path& path, Body&& body, const char* failure = "is truncated or damaged") {
  try {
    return body();
  } catch (const InputError&) {
    throw;
  } catch (const Refusal& refusal) {
    throw file_error(path, refusal.what(), refusal.remedy);
  } catch (const std::bad_alloc&) {
    throw file_error(path, "needs more memory than there is", "use a smaller image");
  } catch (const std::exception& error) {
    throw file_error(path, std::string(failure) + " (" + error.what() + ")", "write or fetch the file again");
  }
}

}  // namespace coppice::exr
