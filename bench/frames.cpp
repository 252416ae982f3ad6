// Frames of the demo scene, from the paper's way to merge and shade them to the library's, against brute
// force in the same run. Writes the report as Markdown to standard output.
#include <coppice/embree/threads.hpp>
#include <coppice/kernels/kernels.hpp>
#include <coppice/reference/merge_face.hpp>
#include <coppice/reference/merge_postorder.hpp>
#include <cstdio>
#include <functional>
#include <string>

#include "check.hpp"
#include "demo.hpp"
#include "machine.hpp"

namespace coppice::bench {
namespace {

constexpr int usual_rounds = 5, rounds_without_simd = 1;
const LobeOptions sampled{Lobes::sampled};

/// Every so manieth face with its points: enough for a mean, and brute force ends in seconds.
ShadingBuffer some_faces(const ShadingBuffer& all, std::size_t stride) {
  ShadingBuffer some;
  for (std::size_t f = 0; f < all.faces.size(); f += stride) {
    some.faces.push_back({all.faces[f].receivers, std::uint32_t(some.points.size())});
    for (std::uint32_t p = all.faces[f].first_point; p < all.end_of(f); ++p) {
      some.points.push_back(all.points[p]);
      some.points.back().face = std::uint32_t(some.faces.size() - 1);
      some.pixels.push_back(all.pixels[p]);
    }
  }
  return some;
}

/// The same points, each with a face of its own: nothing is shared between them.
ShadingBuffer one_point_a_face(const ShadingBuffer& shared) {
  ShadingBuffer alone = shared;
  alone.faces.clear();
  for (std::uint32_t p = 0; p < alone.points.size(); ++p) {
    alone.faces.push_back({shared.faces[shared.points[p].face].receivers, p});
    alone.points[p].face = p;
  }
  return alone;
}

double relative_rms(std::span<const vec3> values, std::span<const vec3> reference) {
  double error = 0, size = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const glm::dvec3 d = glm::dvec3(values[i]) - glm::dvec3(reference[i]);
    error += dot(d, d), size += dot(glm::dvec3(reference[i]), glm::dvec3(reference[i]));
  }
  return std::sqrt(error / size);
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// A way to shade the points of a buffer, and what it was measured to take.
struct Method {
  std::string name;
  std::function<void(std::span<vec3> radiance, std::span<std::uint32_t> clusters)> shade;
  std::vector<double> seconds{};
  std::vector<vec3> radiance{};
  double clusters = 0;  ///< mean a point

  double microseconds() const { return 1e6 * median(seconds) / double(radiance.size()); }
};

/// Rounds go over all methods, so that a slow spell of the machine meets them all.
void measure(std::vector<Method>& methods, std::size_t point_count, int rounds = usual_rounds) {
  for (Method& m : methods) {
    m.radiance.resize(point_count);
    std::vector<std::uint32_t> clusters(point_count, 0);
    m.shade(m.radiance, clusters);
    for (const auto c : clusters) m.clusters += double(c) / double(point_count);
  }
  for (int r = 0; r < rounds; ++r)
    for (Method& m : methods) {
      Stopwatch watch;
      m.shade(m.radiance, {});
      m.seconds.push_back(watch.lap());
    }
}

Method brute_force(const ShadingKernels<std::uint8_t>& kernels, const ShadingBuffer& buffer, Skip skip) {
  const Demo& demo = Demo::get();
  const auto lights =
      std::make_shared<DenseLights>(demo.relighting.tree().leaf_count(), demo.lighting[usual]);
  return {
      skip == Skip::nothing ? "all lights" : "all lights, skipping the unseen",
      [&kernels, &buffer, &demo, lights, skip](std::span<vec3> radiance, std::span<std::uint32_t> counts) {
        if (skip == Skip::nothing) std::ranges::fill(counts, demo.relighting.tree().leaf_count());
        kernels.brute_force(skip, buffer, demo.relighting.bits(), demo.relighting.tree().leaf_count(),
                            *lights, 0, buffer.faces.size(), radiance);
      }};
}

Method by_kernel(std::string name, const ShadingKernels<std::uint8_t>& kernels, const ShadingBuffer& buffer,
                 std::size_t cuts, const FrameLighting& frame, const LobeOptions& lobes) {
  return {std::move(name), [&, cuts, lobes](std::span<vec3> radiance, std::span<std::uint32_t> clusters) {
            kernels.shade_faces(buffer, Demo::get().relighting.cuts(cuts), frame, lobes, 0,
                                buffer.faces.size(), radiance, clusters);
          }};
}

/// Any merge, once a face, then the SIMD shading of the instructions that this file is compiled for.
Method by_merge(std::string name, const ShadingBuffer& buffer,
                std::function<void(const uvec3& receivers, ClusterList&)> merge) {
  return {std::move(name), [&buffer, merge](std::span<vec3> radiance, std::span<std::uint32_t> counts) {
            ClusterList clusters;
            RefinementScratch scratch;
            for (std::size_t f = 0; f < buffer.faces.size(); ++f) {
              merge(buffer.faces[f].receivers, clusters);
              for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p) {
                radiance[p] = shade_point(buffer.points[p], clusters, 1 / quantised_one<std::uint8_t>,
                                          sampled, {}, scratch)
                                  .radiance;
                if (!counts.empty()) counts[p] = std::uint32_t(clusters.size());
              }
            }
          }};
}

using PostorderCuts = std::vector<std::vector<reference::PostorderNode>>;

/// Visibility cuts as the paper stores them, for the receivers that the buffer uses.
PostorderCuts postorder_cuts(const ShadingBuffer& buffer) {
  const auto& cuts = Demo::get().relighting.cuts(usual);
  PostorderCuts nodes(cuts.size());
  for (const ShadingFace& face : buffer.faces)
    for (int k = 0; k < 3; ++k)
      if (auto& own = nodes[face.receivers[k]]; own.empty())
        own = reference::to_postorder(CutView<std::uint8_t>(cuts.unpack(face.receivers[k])));
  return nodes;
}

/// The loop of Cuts section 3.2 over three visibility cuts and the illumination cut.
void merge_as_the_paper(const PostorderCuts& cuts, const std::vector<reference::PostorderNode>& illumination,
                        const uvec3& r, ClusterList& clusters) {
  const Demo& demo = Demo::get();
  const std::uint32_t leaf_count = demo.relighting.tree().leaf_count();
  clusters.reset(cuts[r.x].size() + cuts[r.y].size() + cuts[r.z].size() + illumination.size());
  std::uint32_t begin = 0;
  reference::merge_postorder(
      {cuts[r.x], cuts[r.y], cuts[r.z], illumination}, [&](std::uint32_t leaves, auto n) {
        const std::uint32_t h = node_of_range(leaf_count, begin, begin + leaves);
        const std::array<float, 3> visible{float(n[0].value), float(n[1].value), float(n[2].value)};
        begin += leaves;
        const LightNode& node = demo.lighting[usual].nodes[h];
        if (visible != std::array<float, 3>{} && node.power != vec3(0)) clusters.push(h, node, visible);
      });
  clusters.pad();
}

void print_rows(const std::vector<Method>& methods, const char* instructions) {
  const Method &plain = methods[0], &skipping = methods[1];
  for (const Method& m : methods)
    std::printf("| %s | %s | %.0f | %.2f | %.2f%% | %.1f | %.1f |\n", m.name.c_str(), instructions,
                m.clusters, m.microseconds(), 100 * relative_rms(m.radiance, plain.radiance),
                skipping.microseconds() / m.microseconds(), plain.microseconds() / m.microseconds());
}

/// Fails the report where both brute forces disagree.
void check_twins(const Method& plain, const Method& skipping) {
  if (relative_rms(skipping.radiance, plain.radiance) < 1e-5) return;
  std::fprintf(stderr, "frames: the two brute forces disagree\n");
  check_failed() = true;
}

/// From the paper's merge to the library's defaults, on the scene's own materials.
void speed_table(const ShadingBuffer& buffer, const ShadingBuffer& alone) {
  const Demo& demo = Demo::get();
  static const FrameLighting small = Demo::get().relighting.light(demo.environment, 64, weighted + usual);
  const FrameLighting& frame = demo.lighting[usual];
  const PostorderCuts postorder = postorder_cuts(buffer);
  const auto illumination = reference::to_postorder(
      CutView<std::uint8_t>(Cut<std::uint8_t>{frame.ends, std::vector<std::uint8_t>(frame.ends.size(), 1)}));
  std::printf(
      "\n## Speed: σ = 2, the scene's own materials\n\n%zu points, %.1f a face, one thread, medians of %d "
      "rounds over all rows of an instruction set; errors against all lights.\n\n"
      "| way | instructions | clusters a point | µs a point | relRMSE | × skipping | × plain |\n"
      "|---|---|---|---|---|---|---|\n",
      buffer.points.size(), double(buffer.points.size()) / double(buffer.faces.size()), usual_rounds);
  for (const InstructionSet set : supported_instruction_sets()) {
    const auto& kernels = kernels_for<std::uint8_t>(set);
    std::vector<Method> methods{brute_force(kernels, buffer, Skip::nothing),
                                brute_force(kernels, buffer, Skip::unseen)};
    if (kernels.width == Lanes::width) {
      methods.push_back(by_merge("256 nodes, the paper's merge", buffer, [&](const uvec3& r, ClusterList& c) {
        merge_as_the_paper(postorder, illumination, r, c);
      }));
      methods.push_back(by_merge("256 nodes, portable merge", buffer, [&](const uvec3& r, ClusterList& c) {
        reference::merge_face(demo.relighting.cuts(usual), r, frame, c);
      }));
    }
    methods.push_back(by_kernel("256 nodes, merged for each point", kernels, alone, usual, frame, sampled));
    methods.push_back(by_kernel("256 nodes", kernels, buffer, usual, frame, sampled));
    methods.push_back(by_kernel("64 nodes, weighted cuts, refined lobes (the default)", kernels, buffer,
                                weighted + usual, small, LobeOptions{}));
    measure(methods, buffer.points.size(), kernels.width == 1 ? rounds_without_simd : usual_rounds);
    check_twins(methods[0], methods[1]);
    print_rows(methods, name(set));
    std::fflush(stdout);
  }
}

struct Material {
  std::string name;
  std::function<void(ShadingPoint&)> set;
};

Material metal(float alpha) {
  return {"metal, GGX α " + std::to_string(alpha).substr(0, 4),
          [=](ShadingPoint& p) { set_metallic_roughness(p, vec3(1), 1, std::sqrt(alpha)); }};
}
Material dielectric(float alpha) {
  return {"dielectric, GGX α " + std::to_string(alpha).substr(0, 4),
          [=](ShadingPoint& p) { set_metallic_roughness(p, vec3(0.5f), 0, std::sqrt(alpha)); }};
}
Material phong(int exponent) {
  return {"half Phong " + std::to_string(exponent),
          [=](ShadingPoint& p) { set_phong(p, vec3(0.5f), vec3(0.5f), float(exponent)); }};
}

/// A way to shade: which cuts, how many nodes, how the lobes meet them.
struct Setting {
  const char* name;
  std::size_t cuts;
  const FrameLighting& frame;
  LobeOptions lobes;
};

/// Errors of each setting for one material, of all points alike; time against the first setting.
void print_material(const Material& material, ShadingBuffer buffer, std::span<const Setting> settings) {
  for (ShadingPoint& p : buffer.points) material.set(p);
  const auto& kernels = best_kernels<std::uint8_t>();
  std::vector<Method> truth{brute_force(kernels, buffer, Skip::unseen)}, methods;
  truth[0].radiance.resize(buffer.points.size());
  truth[0].shade(truth[0].radiance, {});
  for (const Setting& s : settings)
    methods.push_back(by_kernel(s.name, kernels, buffer, s.cuts, s.frame, s.lobes));
  measure(methods, buffer.points.size());
  std::printf("| %s |", material.name.c_str());
  for (const Method& m : methods)
    std::printf(" %.2f%% | %.0f | %.2f |", 100 * relative_rms(m.radiance, truth[0].radiance), m.clusters,
                m.microseconds() / methods[0].microseconds());
  std::printf("\n");
  std::fflush(stdout);
}

void glossy_table(const ShadingBuffer& buffer) {
  Demo& demo = Demo::get();
  const FrameLighting small = demo.relighting.light(demo.environment, 64, weighted + usual),
                      fine = demo.relighting.light(demo.environment, 64, weighted);
  const Setting settings[] = {{"sampled", usual, demo.lighting[usual], sampled},
                              {"filtered", usual, demo.lighting[usual], {Lobes::filtered}},
                              {"refined", weighted + usual, small, {}},
                              {"refined, σ = 1", weighted, fine, {}}};
  std::printf(
      "\n## Glossy: every point of the scene with one material\n\nEach cell: relRMSE against all lights, "
      "clusters "
      "evaluated a point, time as a multiple of the first column's. *Sampled* and *filtered*: unweighted "
      "cuts by "
      "threshold, σ = 2, 256 nodes. *Refined*: weighted cuts, 64 nodes, tolerance %g.\n\n"
      "| material | sampled | clusters | time | filtered | clusters | time | refined, σ = 2 | clusters | "
      "time | "
      "refined, σ = 1 | clusters | time |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      double(LobeOptions{}.tolerance));
  for (const float alpha : {0.02f, 0.05f, 0.1f, 0.16f, 0.3f, 0.6f, 1.0f})
    print_material(metal(alpha), buffer, settings);
  for (const float alpha : {0.02f, 0.05f, 0.1f, 0.16f, 0.3f, 0.6f, 1.0f})
    print_material(dielectric(alpha), buffer, settings);
  for (const int exponent : {2000, 500, 100, 20, 5}) print_material(phong(exponent), buffer, settings);
  print_material({"Lambert", [](ShadingPoint& p) { set_lambert(p, vec3(0.5f)); }}, buffer, settings);
}

}  // namespace
}  // namespace coppice::bench

int main() {
  using namespace coppice::bench;
  const auto& relighting = Demo::get().relighting;
  std::printf("# Frames\n\nFlight helmet under the workshop's lamps, %d×%d, %zu receivers, %zu lights; %s.\n",
              relighting.options().raster.width, relighting.options().raster.height,
              relighting.receivers().size(), relighting.directions().size(), processor().c_str());
  const coppice::ShadingBuffer buffer = some_faces(relighting.buffer(), 4);
  speed_table(buffer, one_point_a_face(buffer));
  glossy_table(relighting.buffer());  // all points: a lost highlight may be a few of them
  return check_failed() ? 1 : 0;
}
