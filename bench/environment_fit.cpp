// The environment as Gaussians: errors, counts and times of the fit for the maps named on the command line,
// the errors and times of the pre-convolved table, and what culling by bound saves. docs/sg.md shows its
// tables.
//   environment_fit [--pictures FOLDER] [--tables fits,knobs,preconvolved,culling] MAP...
// Errors are relative RMS over 300 directions and three channels, of the map convolved with a lobe.
#include <coppice/core/simd.hpp>
//
#include <algorithm>
#include <coppice/core/random.hpp>
#include <coppice/core/stopwatch.hpp>
#include <coppice/exr/exposure.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/light/directions.hpp>
#include <coppice/reference/environment_fit.hpp>
#include <coppice/sg/environment_fit.hpp>
#include <coppice/sg/light_bound.hpp>
#include <coppice/sg/preconvolved.hpp>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>

namespace coppice::bench {
namespace {

constexpr double exponents[] = {1, 50};

struct Map {
  std::string name;
  Environment environment;
  std::vector<glm::dvec3> convolved[2];  ///< by exponent, once asked for
};

const std::vector<vec3> axes = even_directions(300, 5);

void convolve(Map& map) {
  for (int e = 0; e < 2; ++e)
    for (const vec3& axis : axes)
      map.convolved[e].push_back(reference::convolve(map.environment, axis, exponents[e]));
}

/// The least of a few times, in milliseconds.
template <class Work>
double milliseconds(const Work& work) {
  double least = 1e30;
  for (int i = 0; i < 9; ++i) {
    const Stopwatch watch;
    work();
    least = std::min(least, watch.seconds());
  }
  return 1e3 * least;
}

double negative_share(std::span<const SgLight> lights) {
  double negative = 0, all = 0;
  for (const SgLight& light : lights)
    for (int c = 0; c < 3; ++c) {
      const double energy = double(sg_integral(light.sharpness)) * double(light.amplitude[c]);
      all += std::abs(energy), negative += std::max(0.0, -energy);
    }
  return all > 0 ? negative / all : 0;
}

glm::dvec3 energy_of(const Image& map) {
  glm::dvec3 sum(0);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      sum += texel_solid_angle(y, map.width, map.height) * glm::dvec3(map.at(x, y));
  return sum;
}

void print_fit(const Map& map, const EnvironmentFitter& fitter, const char* label) {
  EnvironmentFit fit;
  const double ms = milliseconds([&] { fit = fitter.fit(map.environment); });
  double errors[2];
  for (int e = 0; e < 2; ++e)
    errors[e] =
        reference::relative_rms(reference::convolve(fit.lights, axes, exponents[e]), map.convolved[e]);
  const glm::dvec3 energy = energy_of(map.environment.map);
  const double lost = glm::length(sg_energy(fit.lights) - energy) / glm::length(energy);
  const double peaks = double(luminance(vec3(sg_energy(fit.peaks()) / glm::length(energy)))) /
                       double(luminance(vec3(energy / glm::length(energy))));
  std::printf("| %s | %s | %zu + %zu | %.0f%% | %.3f%% | %.3f%% | %.0e | %.0f%% | %.1f |\n", map.name.c_str(),
              label, fit.peak_count, fit.rest().size(), 100 * peaks, 100 * errors[0], 100 * errors[1], lost,
              100 * negative_share(fit.rest()), ms);
}

void print_fits(const std::vector<Map>& maps, const char* label, const EnvironmentFitOptions& options) {
  for (const Map& map : maps) {
    const Image& image = map.environment.map;
    print_fit(map, EnvironmentFitter(options, image.width, image.height), label);
  }
}

void print_all_fits(const std::vector<Map>& maps) {
  std::printf("| Map | Fit | Gaussians | Peaks' energy | Cosine | Phong 50 | Energy | Negative | ms |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|\n");
  for (const FitScheme scheme : {FitScheme::one_level, FitScheme::pyramid})
    for (const std::size_t most : {32u, 0u}) {
      EnvironmentFitOptions options;
      options.scheme = scheme, options.peaks.most = most;
      print_fits(maps, scheme == FitScheme::one_level ? "one level" : "pyramid", options);
    }
}

/// The worst errors over all maps.
void print_knob(const std::vector<Map>& maps, const std::string& label,
                const EnvironmentFitOptions& options) {
  double worst[2] = {}, negative = 0, ms = 0;
  for (const Map& map : maps) {
    const EnvironmentFitter fitter(options, map.environment.map.width, map.environment.map.height);
    EnvironmentFit fit;
    ms = std::max(ms, milliseconds([&] { fit = fitter.fit(map.environment); }));
    for (int e = 0; e < 2; ++e)
      worst[e] = std::max(
          worst[e],
          reference::relative_rms(reference::convolve(fit.lights, axes, exponents[e]), map.convolved[e]));
    negative = std::max(negative, negative_share(fit.rest()));
  }
  std::printf("| %s | %.3f%% | %.3f%% | %.0f%% | %.1f |\n", label.c_str(), 100 * worst[0], 100 * worst[1],
              100 * negative, ms);
}

void print_knobs(const std::vector<Map>& maps) {
  std::printf("\n| Knob | Cosine | Phong 50 | Negative | ms |\n|---|---|---|---|---|\n");
  const auto print = [&](const char* name, auto member, auto value) {
    EnvironmentFitOptions options;
    member(options) = value;
    char label[64];
    std::snprintf(label, sizeof label, "%s %g", name, double(value));
    print_knob(maps, label, options);
  };
  print_knob(maps, "defaults", {});
  for (const int n : {4, 6, 9, 16})
    print(
        "nside", [](auto& o) -> int& { return o.nside; }, n);
  for (const float v : {0.4f, 0.5f, 0.7f})
    print(
        "overlap", [](auto& o) -> float& { return o.overlap; }, v);
  for (const int n : {1, 2, 4, 8, 32})
    print(
        "passes", [](auto& o) -> int& { return o.passes; }, n);
  for (const float w : {0.25f, 1.0f, 2.0f})
    print(
        "window", [](auto& o) -> float& { return o.window; }, w);
  for (const int n : {16, 64})
    print(
        "grid_nside", [](auto& o) -> int& { return o.grid_nside; }, n);
  for (const float t : {4.0f, 16.0f})
    print(
        "threshold", [](auto& o) -> float& { return o.peaks.threshold; }, t);
  for (const int n : {1, 2})
    print(
        "per_peak", [](auto& o) -> int& { return o.peaks.per_peak; }, n);
  for (const std::size_t n : {0u, 4u, 8u, 16u})
    print(
        "most", [](auto& o) -> std::size_t& { return o.peaks.most; }, n);
}

/// Direct sums over lights: the mean radiance under each Gaussian.
std::vector<glm::dvec3> direct_means(std::span<const SgLight> lights, std::span<const SgShape> queries) {
  std::vector<glm::dvec3> means;
  for (const SgShape& query : queries) {
    glm::dvec3 sum(0);
    for (const SgLight& light : lights)
      sum += double(sg_inner_product({light.axis, light.sharpness}, query)) * glm::dvec3(light.amplitude);
    means.push_back(sum / double(sg_integral(query.sharpness)));
  }
  return means;
}

std::vector<glm::dvec3> table_means(const PreconvolvedEnvironment& table, std::span<const SgShape> queries) {
  std::vector<glm::dvec3> means;
  for (const SgShape& query : queries) means.push_back(glm::dvec3(table.mean(query)));
  return means;
}

double lookup_nanoseconds(const PreconvolvedEnvironment& table, std::span<const SgShape> queries) {
  vec3 sum(0);
  const double ms = milliseconds([&] {
    for (const SgShape& query : queries) sum += table.lookup(query);
  });
  if (!is_finite(sum)) std::printf("not finite\n");
  return 1e6 * ms / double(queries.size());
}

constexpr float sharpnesses[] = {1, 4, 16, 64, 256};

std::vector<SgShape> queries_of(float sharpness) {
  std::vector<SgShape> queries;
  for (const vec3& d : even_directions(500, 7)) queries.push_back({d, sharpness});
  return queries;
}

/// Errors against `truth`, the lights that the table should stand for.
void print_table(const Map& map, const char* source, std::span<const SgLight> lights,
                 std::span<const SgLight> truth, const PreconvolvedOptions& options) {
  const double ms = milliseconds([&] { PreconvolvedEnvironment(lights, options); });
  const PreconvolvedEnvironment table(lights, options);
  std::printf("| %s | %s | %g, %g | %zu |", map.name.c_str(), source, double(options.levels_per_octave),
              double(options.texels_per_width), table.texel_count());
  for (const float sharpness : sharpnesses) {
    const auto queries = queries_of(sharpness * 1.17f);  // not that of a level
    std::printf(" %.2f%% |",
                100 * reference::relative_rms(table_means(table, queries), direct_means(truth, queries)));
  }
  std::printf(" %.1f | %.0f |\n", ms, lookup_nanoseconds(table, queries_of(20)));
}

void print_tables(const std::vector<Map>& maps) {
  std::printf(
      "\n| Map | From | Levels an octave, texels a width | Texels | λ 1 | 4 | 16 | 64 | 256 | ms | ns |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Map& map : maps) {
    const Image& image = map.environment.map;
    const EnvironmentFitter fitter({}, image.width, image.height);
    const EnvironmentFit fit = fitter.fit(map.environment);
    const auto cells = cell_lights(fitter.grid(), fitter.grid().gather(image), fit.peaks());
    print_table(map, "fit", fit.rest(), fit.rest(), {1, 2, 511});
    print_table(map, "fit", fit.rest(), fit.rest(), {2, 2, 511});
    print_table(map, "fit", fit.rest(), fit.rest(), {2, 4, 511});
    print_table(map, "fit, against cells", fit.rest(), cells, {});
    print_table(map, "cells, against cells", cells, cells, {});
  }
}

/// What each light brings to the lobe about each axis.
std::vector<std::vector<glm::dvec3>> contributions(std::span<const SgLight> lights, double exponent) {
  std::map<float, reference::GaussianConvolution> tables;
  std::vector<std::vector<glm::dvec3>> all(axes.size());
  for (const SgLight& light : lights) {
    const auto& table = tables.try_emplace(light.sharpness, double(light.sharpness), exponent).first->second;
    for (std::size_t i = 0; i < axes.size(); ++i)
      all[i].push_back(table.at(double(dot(light.axis, axes[i]))) * glm::dvec3(light.amplitude));
  }
  return all;
}

struct Culled {
  double error = 0, left_out = 0;
};

/// With lights left out whose bound is below `share` of the result, over the number of lights.
Culled cull(std::span<const SgLight> lights, const std::vector<std::vector<glm::dvec3>>& each,
            double exponent, double share) {
  std::vector<glm::dvec3> kept(axes.size(), glm::dvec3(0)), whole = kept;
  Culled result;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    for (const glm::dvec3& value : each[i]) whole[i] += value;
    const double threshold = share * double(luminance(vec3(whole[i]))) / double(lights.size());
    for (std::size_t k = 0; k < lights.size(); ++k) {
      const SgLightBound bound(lights[k].sharpness, float(exponent));
      if (dot(lights[k].axis, axes[i]) > bound.least_cosine(lights[k].luminance, float(threshold)))
        kept[i] += each[i][k];
      else
        result.left_out += 1.0 / double(lights.size() * axes.size());
    }
  }
  result.error = reference::relative_rms(kept, whole);
  return result;
}

/// The share of lights that the bound leaves out at an error of 0.1%, bisecting the threshold.
void print_culling(const std::vector<Map>& maps) {
  std::printf("\n| Map | Lobe | Lights left out at 0.1%% | Threshold |\n|---|---|---|---|\n");
  for (const Map& map : maps) {
    const Image& image = map.environment.map;
    const EnvironmentFit fit = EnvironmentFitter({}, image.width, image.height).fit(map.environment);
    for (const double exponent : exponents) {
      const auto each = contributions(fit.lights, exponent);
      double low = -30, high = 8;  // log2 of the share
      for (int step = 0; step < 12; ++step) {
        const double middle = (low + high) / 2;
        (cull(fit.lights, each, exponent, std::exp2(middle)).error < 1e-3 ? low : high) = middle;
      }
      const Culled culled = cull(fit.lights, each, exponent, std::exp2(low));
      std::printf("| %s | %s | %.0f%% | %.2g |\n", map.name.c_str(), exponent == 1 ? "Lambert" : "Phong 50",
                  100 * culled.left_out, std::exp2(low));
    }
  }
}

/// Above one another: the map, all Gaussians, the peaks alone, and what lobes of Phong 50 see of the map and
/// of the Gaussians.
void write_pictures(const Map& map, const std::filesystem::path& folder) {
  const EnvironmentFit fit =
      EnvironmentFitter({}, map.environment.map.width, map.environment.map.height).fit(map.environment);
  const int width = 256, height = 128;
  Image picture(width, 3 * height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const vec3 d = texel_direction(x, y, width, height);
      picture.at(x, y) = radiance(map.environment, d);
      picture.at(x, y + height) = vec3(glm::max(reference::radiance(fit.lights, d), glm::dvec3(0)));
      picture.at(x, y + 2 * height) = vec3(reference::radiance(fit.peaks(), d));
    }
  write_exr(folder / (map.name + ".exr"), picture.width, picture.height, {{"", picture}});
  write_png(folder / (map.name + ".png"), picture, automatic_exposure(map.environment.map));
}

int run(int count, char** arguments) {
  std::filesystem::path pictures;
  std::string tables = "fits,knobs,preconvolved,culling";
  std::vector<Map> maps;
  for (int i = 1; i < count; ++i)
    if (std::string(arguments[i]) == "--pictures" && i + 1 < count)
      pictures = arguments[++i];
    else if (std::string(arguments[i]) == "--tables" && i + 1 < count)
      tables = arguments[++i];
    else
      maps.push_back(
          {std::filesystem::path(arguments[i]).stem().string(), read_environment(arguments[i]), {}});
  if (maps.empty()) {
    std::fprintf(stderr, "usage: environment_fit [--pictures FOLDER] [--tables LIST] MAP...\n");
    return 2;
  }
  if (!pictures.empty())
    for (const Map& map : maps) write_pictures(map, pictures);
  const auto asked = [&](const char* name) { return tables.find(name) != std::string::npos; };
  if (asked("fits") || asked("knobs"))
    for (Map& map : maps) convolve(map);
  if (asked("fits")) print_all_fits(maps);
  if (asked("knobs")) print_knobs(maps);
  if (asked("preconvolved")) print_tables(maps);
  if (asked("culling")) print_culling(maps);
  return 0;
}

}  // namespace
}  // namespace coppice::bench

int main(int count, char** arguments) {
  try {
    return coppice::bench::run(count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
