// Lights of a scene by shadow rays: a traced cut a point against lights drawn as renderers draw them, by the
// error at equal rays. Writes the report as Markdown to standard output.
#include <CLI/CLI.hpp>
#include <coppice/core/error.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/gltf/load.hpp>
#include <coppice/light/direct_irradiance.hpp>
#include <coppice/light/scene_lights.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <coppice/relight/traced_lighting.hpp>
#include <coppice/trade/errors.hpp>
#include <cstdio>
#include <ctime>
#include <functional>

#include "check.hpp"
#include "machine.hpp"
#include "rooms.hpp"

namespace coppice::bench {
namespace {

const Serial one_thread;

struct Options {
  std::string scene;
  int width = 320, height = 180;
  std::size_t stride = 4, emitters = 1024;
  int rounds = 3;
};

/// Every so manieth point, without faces.
ShadingBuffer some_points(const ShadingBuffer& all, std::size_t stride) {
  ShadingBuffer some;
  for (std::size_t p = 0; p < all.points.size(); p += stride) {
    some.points.push_back(all.points[p]);
    some.positions.push_back(all.positions[p]);
  }
  return some;
}

ShadingBuffer seen_points(const Scene& scene, const EmbreeTracer& tracer, const Options& options) {
  if (!scene.camera) throw InputError(options.scene, "has no camera", "add one to the glTF file");
  const auto hits = trace_camera(tracer, *scene.camera, {options.width, options.height, 1}, one_thread);
  const ReceiverMesh mesh(scene.mesh, sides_seen(scene.mesh, hits));
  return some_points(make_shading_buffer(scene, mesh, hits, Shading::metallic_roughness, one_thread),
                     options.stride);
}

/// What all methods share.
struct Subject {
  Scene scene;
  EmbreeTracer tracer;
  ShadingBuffer buffer;
  std::vector<LocalLight> lights;
  LightTree tree;
  LocalLighting lighting;

  Subject(Scene s, const Options& options)
      : scene(std::move(s)),
        tracer(scene),
        buffer(seen_points(scene, tracer, options)),
        lights(scene_lights(scene, options.emitters)),
        tree(build_local_tree(lights)),
        lighting(tree, lights) {
    if (lights.empty()) throw InputError(options.scene, "has no lights", "choose another scene");
    lighting.set_cut(64, 0);
  }
};

struct Result {
  std::vector<vec3> radiance;
  double rays = 0, microseconds = 0;  ///< a point
  double error = 0;                   ///< rel_mse
};

/// Shades all points and tells how many rays that took.
using Method = std::function<std::vector<vec3>(std::size_t& rays)>;

double error_of(const std::vector<vec3>& radiance, const std::vector<vec3>& reference) {
  Image x(int(radiance.size()), 1), r(int(radiance.size()), 1);
  x.pixels = radiance, r.pixels = reference;
  return image_errors(x, r, std::vector<bool>(radiance.size(), true)).rel_mse;
}

/// The time, of the processor, is the median of the rounds; of one where it takes long.
Result measure(const Method& shade, const std::vector<vec3>& reference, int rounds) {
  Result result;
  std::vector<double> seconds;
  std::size_t rays = 0;
  while (seconds.empty() || (std::ssize(seconds) < rounds && seconds[0] < 4)) {
    const std::clock_t begin = std::clock();
    rays = 0;
    result.radiance = shade(rays);
    seconds.push_back(double(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  std::ranges::sort(seconds);
  const double points = double(result.radiance.size());
  result.rays = double(rays) / points;
  result.microseconds = 1e6 * seconds[seconds.size() / 2] / points;
  if (!reference.empty()) result.error = error_of(result.radiance, reference);
  return result;
}

Method traced(const Subject& subject, float tolerance) {
  return [&subject, tolerance](std::size_t& rays) {
    std::vector<std::uint32_t> each(subject.buffer.points.size());
    auto radiance =
        shade_traced(subject.buffer, subject.lighting, subject.tracer, {tolerance}, one_thread, each);
    rays = std::accumulate(each.begin(), each.end(), std::size_t(0));
    return radiance;
  };
}

/// Adds rays(leaf, weight) from a point.
using AddRay = std::function<void(std::uint32_t leaf, float weight)>;

/// Shades every point by the rays that draw(point, add) adds, `most` at most.
template <class Draw>
Method drawn(const Subject& subject, std::size_t most, Draw draw) {
  return [&subject, most, draw](std::size_t& rays) {
    const ShadingBuffer& buffer = subject.buffer;
    std::vector<vec3> radiance(buffer.points.size());
    LightRays<EmbreeTracer> to_lights(subject.lighting, subject.tracer);
    const std::uint32_t leaf_count = subject.tree.leaf_count();
    for (std::size_t p = 0; p < radiance.size(); ++p) {
      to_lights.begin(buffer.positions[p], buffer.points[p].normal, most);
      draw(p,
           [&](std::size_t rank, float weight) { to_lights.add(leaf_count + std::uint32_t(rank), weight); });
      const ClusterList& reached = to_lights.end();
      rays += to_lights.traced();
      radiance[p] = with_brdf(buffer.points[p], [&](const auto& brdf) {
        using B = std::decay_t<decltype(brdf)>;
        return PointShader<B, LocalLights>(buffer.points[p], brdf, 1, LocalLights(buffer.positions[p]))
            .sampled(reached);
      });
    }
    return radiance;
  };
}

Method all_lights(const Subject& subject) {
  const std::uint32_t count = subject.tree.leaf_count();
  return drawn(subject, count, [count](std::size_t, auto&& add) {
    for (std::uint32_t rank = 0; rank < count; ++rank) add(rank, 1.0f);
  });
}

/// What the leaves send out, however near a point is to them.
std::vector<float> powers(const Subject& subject) {
  std::vector<float> result;
  for (const std::uint32_t light : subject.tree.light_of_leaf)
    result.push_back(light == no_light ? 0.0f : detail::powers({&subject.lights[light], 1})[0]);
  return result;
}

/// Sums of powers up to and with each leaf.
std::vector<double> sums_of_powers(const Subject& subject) {
  const auto each = powers(subject);
  std::vector<double> sums(each.begin(), each.end());
  std::partial_sum(sums.begin(), sums.end(), sums.begin());
  return sums;
}

/// The usual way of renderers: each ray draws a light by its power, whatever the others drew.
Method by_power(const Subject& subject, std::size_t count) {
  return drawn(subject, count, [sums = sums_of_powers(subject), count](std::size_t p, auto&& add) {
    Random random(Random(p).bits());
    for (std::size_t i = 0; i < count; ++i) {
      const double at = double(random.uniform()) * sums.back();
      const auto it = std::ranges::upper_bound(sums, at);
      const double power = *it - (it == sums.begin() ? 0.0 : it[-1]);
      add(std::size_t(it - sums.begin()), float(sums.back() / (power * double(count))));
    }
  });
}

/// The same with draws a step apart over the lights in the order of the tree, so that near lights share few.
Method by_power_in_steps(const Subject& subject, std::size_t count) {
  const detail::WeightedItems items(powers(subject));
  return drawn(subject, count, [items, count](std::size_t p, auto&& add) {
    Random random(Random(p).bits());
    items.draw(count, random, add);
  });
}

/// What every leaf adds to a point where nothing is in between, as luminance.
std::vector<float> unshadowed(const Subject& subject, std::size_t p) {
  const std::uint32_t count = subject.tree.leaf_count();
  std::vector<float> values((count + Lanes::width) / Lanes::width * Lanes::width);
  const ShadingPoint& point = subject.buffer.points[p];
  const LocalLightNode* nodes = subject.lighting.frame().nodes.data() + count;
  const LocalEmission* emissions = subject.lighting.emissions().data() + count;
  with_brdf(point, [&](const auto& brdf) {
    const NodeBounds bounds(subject.lighting, point, subject.buffer.positions[p], brdf);
    for (std::uint32_t i = 0; i < count; i += Lanes::width)
      bounds.estimate(load_local_nodes(nodes + i, emissions + i, ~0ull)).store(&values[i]);
    return 0;
  });
  values.resize(count);
  return values;
}

/// In steps over the lights, each as long as what it adds to this point without shadows.
Method by_contribution(const Subject& subject, std::size_t count) {
  return drawn(subject, count, [&subject, count](std::size_t p, auto&& add) {
    Random random(Random(p).bits());
    const detail::WeightedItems items(unshadowed(subject, p));
    if (items.positive_count() > 0) items.draw(count, random, add);
  });
}

/// Results for rising counts of rays.
struct Curve {
  const char* name;
  std::vector<Result> results{};

  /// What `figure` (rays or microseconds) is at an error, log-log between two results; of the last where its
  /// error is still greater.
  double at(double error, double Result::*figure) const {
    const auto fine = std::ranges::find_if(results, [&](const Result& r) { return r.error <= error; });
    if (fine == results.end()) return results.back().*figure;
    if (fine == results.begin()) return results.front().*figure;
    const Result &a = fine[-1], &b = *fine;
    const double share = std::log(a.error / error) / std::log(a.error / b.error);
    return std::exp(std::lerp(std::log(a.*figure), std::log(b.*figure), share));
  }
  bool reaches(double error) const { return results.back().error <= error; }
};

void print(const char* name, const std::string& knob, const Result& r) {
  std::printf("| %s | %s | %.1f | %.1f | %.2e |\n", name, knob.c_str(), r.rays, r.microseconds, r.error);
  std::fflush(stdout);
}

Curve measure_curve(const char* name, Method (*method)(const Subject&, std::size_t), std::size_t most,
                    const Subject& subject, const std::vector<vec3>& exact, int rounds) {
  Curve curve{name};
  for (std::size_t count = 1; count <= most; count *= 4) {
    curve.results.push_back(measure(method(subject, count), exact, rounds));
    print(name, std::to_string(count) + " draws", curve.results.back());
  }
  return curve;
}

struct TracedRun {
  float tolerance;
  Result result;
};

void print_ratios(const std::vector<TracedRun>& runs, const std::vector<Curve>& curves, const Result& all) {
  std::printf(
      "\nRays and time at equal rel_mse, as multiples of the traced cut's (>: the most draws err more "
      "still):\n"
      "\n| tolerance | rel_mse |");
  for (const Curve& c : curves) std::printf(" rays: %s | time |", c.name);
  std::printf(" rays: all lights | time |\n|---|---|");
  for (std::size_t i = 0; i < 2 * curves.size() + 2; ++i) std::printf("---|");
  for (const TracedRun& run : runs) {
    const Result& r = run.result;
    std::printf("\n| %g | %.1e |", double(run.tolerance), r.error);
    for (const Curve& c : curves) {
      const char* sign = c.reaches(r.error) ? "" : "> ";
      std::printf(" %s%.1f× | %s%.1f× |", sign, c.at(r.error, &Result::rays) / r.rays, sign,
                  c.at(r.error, &Result::microseconds) / r.microseconds);
    }
    std::printf(" %.1f× | %.1f× |", all.rays / r.rays, all.microseconds / r.microseconds);
  }
  std::printf("\n");
}

/// Every ray and every light: the exact sum, which two programs must agree on.
Result exact_sum(const Subject& subject, int rounds) {
  const Result all = measure(all_lights(subject), {}, rounds);
  std::size_t rays = 0;
  if (error_of(traced(subject, 0)(rays), all.radiance) > 1e-9) check_failed() = true;
  return all;
}

void report(const Subject& subject, const Options& options) {
  const Result all = exact_sum(subject, options.rounds);
  std::printf(
      "\n## Many lights by shadow rays: %s, %zu lights, %zu points, one thread\n\n%s.\n\n"
      "| method | | shadow rays a point | µs a point | rel_mse |\n|---|---|---|---|---|\n",
      options.scene.empty() ? "rooms" : options.scene.substr(options.scene.rfind('/') + 1).c_str(),
      subject.lights.size(), subject.buffer.points.size(), processor().c_str());
  print("all lights above the horizon", "", all);
  std::vector<TracedRun> runs;
  for (const float tolerance : {2.0f, 0.5f, 0.2f, 0.1f, 0.05f, 0.02f, 0.01f}) {
    runs.push_back({tolerance, measure(traced(subject, tolerance), all.radiance, options.rounds)});
    char knob[32];
    std::snprintf(knob, sizeof knob, "tolerance %g", double(tolerance));
    print("traced cut", knob, runs.back().result);
  }
  std::vector<Curve> curves;
  const auto add = [&](const char* name, Method (*method)(const Subject&, std::size_t), std::size_t most) {
    curves.push_back(measure_curve(name, method, most, subject, all.radiance, options.rounds));
  };
  add("by power", by_power, 4096);
  add("by power, in steps", by_power_in_steps, 1024);
  add("by unshadowed contribution", by_contribution, 1024);
  print_ratios(runs, curves, all);
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Lights of a scene by shadow rays: traced cuts against drawing lights");
  app.add_option("--scene", options.scene, "glTF file with lights and a camera; rooms with lamps if none");
  app.add_option("--width", options.width);
  app.add_option("--height", options.height);
  app.add_option("--stride", options.stride, "every so manieth point")->check(CLI::PositiveNumber);
  app.add_option("--emitters", options.emitters, "samples of shining surfaces");
  app.add_option("--rounds", options.rounds, "of which the median time counts");
  CLI11_PARSE(app, argc, argv);
  const Subject subject(options.scene.empty() ? lit_rooms() : load_gltf(options.scene), options);
  report(subject, options);
  return check_failed() ? 1 : 0;
}

}  // namespace
}  // namespace coppice::bench

int main(int argc, char** argv) {
  try {
    return coppice::bench::run(argc, argv);
  } catch (const coppice::InputError& e) {
    std::fprintf(stderr, "many_lights: %s\n", e.what());
    return 2;
  }
}
