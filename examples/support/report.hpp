// The report: settings, counts, times and errors as JSON.
#pragma once

#include <coppice/relight/cut_relighting.hpp>
#include <coppice/trade/errors.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <support/program.hpp>
#include <vector>

namespace coppice::program {

nlohmann::json settings_json(const CommonOptions& common, const CutOptions& cut);
nlohmann::json preparation_json(const CutRelighting<>& relighting, const Scene& scene);
/// Minimum, mean and maximum of counts; all 0 where there are none.
struct CountSummary {
  std::size_t min = 0, max = 0;
  double mean = 0;
};
CountSummary summary_of(std::span<const std::uint32_t> counts);
nlohmann::json summary_json(const CountSummary& summary);

/// Minimum, mean and maximum pieces of a set of visibility cuts, and its bytes.
template <Quantised Value>
nlohmann::json cuts_json(const MaskedCuts<Value>& cuts) {
  std::vector<std::uint32_t> pieces;
  for (std::size_t i = 0; i < cuts.size(); ++i) pieces.push_back(std::uint32_t(cuts.piece_count(i)));
  nlohmann::json j = summary_json(summary_of(pieces));
  j["bytes"] = cuts.byte_count();
  return j;
}
nlohmann::json errors_json(const ImageErrors& errors);

/// Pixels over which errors are counted: covered, and not showing an emitter.
std::vector<bool> counted_pixels(const DirectImage& direct);
/// Errors over the counted pixels, as means over blocks where block > 1.
ImageErrors compare(const Image& image, const Image& reference, const std::vector<bool>& counts, int block);
/// The image of --compare. Throws InputError where its size differs.
Image read_comparison(const std::filesystem::path& path, const Raster& raster);

/// Writes the JSON, whole or not at all.
void write_report(const std::filesystem::path& path, const nlohmann::json& report);

double median(std::vector<double> values);

}  // namespace coppice::program
