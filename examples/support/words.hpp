// The words for the library's choices, on the command line and in reports.
#pragma once

#include <CLI/CLI.hpp>
#include <coppice/kernels/kernels.hpp>
#include <coppice/relight/cut_relighting.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace coppice::program {

template <class Choice>
using Words = std::vector<std::pair<std::string, Choice>>;

/// How visibility cuts are made; trade sweeps the two choices together.
struct CutKind {
  CutWeight weight = VisibilityCutOptions{}.weight;
  CutSearch search = VisibilityCutOptions{}.search;
  friend bool operator==(const CutKind&, const CutKind&) = default;
};

inline const Words<CutWeight> weight_words{{"uniform", CutWeight::uniform}, {"cosine", CutWeight::cosine}};
inline const Words<CutSearch> search_words{{"threshold", CutSearch::threshold},
                                           {"optimal", CutSearch::optimal}};
inline const Words<CutKind> cut_kind_words{{"uniform-threshold", {CutWeight::uniform, CutSearch::threshold}},
                                           {"uniform-optimal", {CutWeight::uniform, CutSearch::optimal}},
                                           {"cosine-threshold", {CutWeight::cosine, CutSearch::threshold}},
                                           {"cosine-optimal", {CutWeight::cosine, CutSearch::optimal}}};
inline const Words<Lobes> lobes_words{
    {"sampled", Lobes::sampled}, {"filtered", Lobes::filtered}, {"refined", Lobes::refined}};
inline const Words<std::optional<InstructionSet>> instruction_words{{"auto", std::nullopt},
                                                                    {"avx512", InstructionSet::avx512},
                                                                    {"avx2", InstructionSet::avx2},
                                                                    {"baseline", InstructionSet::baseline}};
inline const Words<ReceiverScope> scope_words{{"seen", ReceiverScope::seen}, {"all", ReceiverScope::all}};
inline const Words<Shading> shading_words{{"gltf", Shading::metallic_roughness},
                                          {"lambert", Shading::lambert},
                                          {"phong", Shading::phong},
                                          {"blinn-phong", Shading::blinn_phong},
                                          {"ward", Shading::ward}};

template <class Choice>
std::string word_of(const Words<Choice>& words, const Choice& choice) {
  for (const auto& [word, meaning] : words)
    if (meaning == choice) return word;
  return "";
}

template <class Choice>
std::optional<Choice> choice_of(const Words<Choice>& words, const std::string& text) {
  for (const auto& [word, meaning] : words)
    if (word == text) return meaning;
  return std::nullopt;
}

/// "uniform|cosine"
template <class Choice>
std::string all_words(const Words<Choice>& words) {
  std::string text;
  for (const auto& [word, meaning] : words) text += (text.empty() ? "" : "|") + word;
  return text;
}

/// Accepts these words and no others.
template <class Choice>
CLI::Validator is_word_of(const Words<Choice>& words) {
  std::vector<std::string> known;
  for (const auto& [word, meaning] : words) known.push_back(word);
  return CLI::IsMember(known);
}

/// An option whose value is a word; its help ends in the default. `value` and `words` outlive the app.
template <class Choice>
void add_choice(CLI::App& app, const std::string& name, Choice& value, const Words<Choice>& words,
                const std::string& help) {
  const auto read = [&](const std::string& text) { value = choice_of(words, text).value(); };
  app.add_option_function<std::string>(name, read, help + " (" + word_of(words, value) + ")")
      ->check(is_word_of(words))
      ->option_text(all_words(words));
}

/// The same for words separated by commas.
template <class Choice>
void add_choices(CLI::App& app, const std::string& name, std::vector<Choice>& values,
                 const Words<Choice>& words, const std::string& help) {
  const auto read = [&](const std::vector<std::string>& texts) {
    values.clear();
    for (const auto& text : texts) values.push_back(choice_of(words, text).value());
  };
  app.add_option_function<std::vector<std::string>>(name, read,
                                                    help + " (" + word_of(words, values.front()) + ")")
      ->delimiter(',')
      ->check(is_word_of(words))
      ->option_text(all_words(words) + ",...");
}

}  // namespace coppice::program
