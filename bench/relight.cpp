// Shading from clusters, and the sums over all lights that it replaces.
#include <coppice/reference/dense.hpp>
#include <coppice/trade/errors.hpp>

#include "check.hpp"
#include "demo.hpp"

namespace coppice::bench {
namespace {

constexpr float visibility_scale = 1 / quantised_one<std::uint8_t>;

/// Points of the demo scene, spread over the image.
const std::vector<std::uint32_t>& chosen_points() {
  static const auto chosen = spread_indices(64, Demo::get().relighting.buffer().points.size());
  return chosen;
}

ShadingPoint with_kind(ShadingPoint point, std::uint32_t kind) {
  const vec3 diffuse(0.5f, 0.4f, 0.3f), specular(0.3f);
  switch (kind) {
    case BRDF_GGX:
      set_metallic_roughness(point, diffuse, 0.2f, 0.5f);
      break;
    case BRDF_PHONG:
      set_phong(point, diffuse, specular, 20);
      break;
    case BRDF_BLINN_PHONG:
      set_blinn_phong(point, diffuse, specular, 40);
      break;
    case BRDF_WARD:
      set_ward(point, diffuse, specular, 0.2f, 0.4f);
      break;
    default:
      set_lambert(point, diffuse);
  }
  return point;
}

std::vector<ShadingPoint> points_of_kind(std::uint32_t kind) {
  std::vector<ShadingPoint> points;
  for (const std::uint32_t p : chosen_points())
    points.push_back(with_kind(Demo::get().relighting.buffer().points[p], kind));
  return points;
}

/// The clusters of the face that has closest to 350 of them.
const ClusterList& usual_clusters() {
  static const ClusterList clusters = [] {
    const Demo& demo = Demo::get();
    FaceMerger<std::uint8_t> merger(demo.relighting.cuts(usual), demo.lighting[usual]);
    ClusterList best, list;
    const auto distance = [](const ClusterList& c) { return std::fabs(double(c.size()) - 350); };
    for (const ShadingFace& face : demo.relighting.buffer().faces) {
      merger.merge(face.receivers, list);
      if (best.size() == 0 || distance(list) < distance(best)) best = list;
    }
    return best;
  }();
  return clusters;
}

/// The slow twin of shade_point: one cluster after the other.
vec3 shade_one_by_one(const ShadingPoint& point, const ClusterList& clusters) {
  std::vector<vec3> directions, powers;
  std::vector<float> visibility;
  const auto at = [&](ClusterList::Field f, std::size_t i) { return clusters.field(f)[i]; };
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    directions.emplace_back(at(ClusterList::x, i), at(ClusterList::y, i), at(ClusterList::z, i));
    powers.emplace_back(at(ClusterList::red, i), at(ClusterList::green, i), at(ClusterList::blue, i));
    visibility.push_back(visibility_scale *
                         (point.weight_0 * at(ClusterList::visible_0, i) +
                          point.weight_1 * at(ClusterList::visible_1, i) +
                          (1 - point.weight_0 - point.weight_1) * at(ClusterList::visible_2, i)));
  }
  return reference::dense_radiance(point, directions, powers, visibility);
}

void shade_clusters(benchmark::State& state, std::uint32_t kind) {
  const ClusterList& clusters = usual_clusters();
  const std::vector<ShadingPoint> points = points_of_kind(kind);
  std::vector<vec3> fast, slow;
  RefinementScratch scratch;
  const auto shade = [&](const ShadingPoint& p) {
    return shade_point(p, clusters, visibility_scale, {Lobes::sampled}, {}, scratch).radiance;
  };
  for (const ShadingPoint& p : points) {
    fast.push_back(shade(p));
    slow.push_back(shade_one_by_one(p, clusters));
  }
  if (!agrees(state, relative_difference(fast, slow), 1e-4)) return;
  state.counters["clusters"] = double(clusters.size());
  state.counters["per_cluster"] = seconds_for_each(double(clusters.size()));
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(shade(points[i++ % points.size()]));
}
BENCHMARK_CAPTURE(shade_clusters, lambert, BRDF_LAMBERT)->Name("relight/shade_point/lambert");
BENCHMARK_CAPTURE(shade_clusters, ggx, BRDF_GGX)->Name("relight/shade_point/ggx");
BENCHMARK_CAPTURE(shade_clusters, phong, BRDF_PHONG)->Name("relight/shade_point/phong");
BENCHMARK_CAPTURE(shade_clusters, blinn_phong, BRDF_BLINN_PHONG)->Name("relight/shade_point/blinn_phong");
BENCHMARK_CAPTURE(shade_clusters, ward, BRDF_WARD)->Name("relight/shade_point/ward");

const DenseLights& all_lights() {
  static const DenseLights lights(Demo::get().relighting.tree().leaf_count(), Demo::get().lighting[usual]);
  return lights;
}

template <Skip skip>
vec3 shade_by_brute_force(const ShadingPoint& point) {
  const Demo& demo = Demo::get();
  const uvec3 r = demo.relighting.buffer().faces[point.face].receivers;
  return shade_brute_force<skip>(point, all_lights(), demo.bits(r.x), demo.bits(r.y), demo.bits(r.z));
}

/// The slow twin of brute force: one leaf after the other, without registers of many.
vec3 shade_leaf_by_leaf(const ShadingPoint& point) {
  const Demo& demo = Demo::get();
  const uvec3 r = demo.relighting.buffer().faces[point.face].receivers;
  const vec3 weights(point.weight_0, point.weight_1, 1 - point.weight_0 - point.weight_1);
  std::vector<vec3> directions, powers;
  std::vector<float> visibility;
  const std::uint32_t n = demo.relighting.tree().leaf_count();
  for (std::uint32_t i = 0; i < n; ++i) {
    directions.push_back(demo.lighting[usual].nodes[n + i].direction);
    powers.push_back(demo.lighting[usual].nodes[n + i].power);
    const vec3 visible(bit_at(demo.bits(r.x).data(), i), bit_at(demo.bits(r.y).data(), i),
                       bit_at(demo.bits(r.z).data(), i));
    visibility.push_back(dot(weights, visible));
  }
  return reference::dense_radiance(point, directions, powers, visibility);
}

template <Skip skip>
double brute_force_error() {
  std::vector<vec3> fast, slow;
  for (const ShadingPoint& p : points_of_kind(BRDF_GGX)) {
    fast.push_back(shade_by_brute_force<skip>(p));
    slow.push_back(shade_leaf_by_leaf(p));
  }
  return relative_difference(fast, slow);
}

template <Skip skip>
void brute_force(benchmark::State& state) {
  static const double error = brute_force_error<skip>();
  if (!agrees(state, error, 1e-4)) return;
  const std::vector<ShadingPoint> points = points_of_kind(BRDF_GGX);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(shade_by_brute_force<skip>(points[i++ % points.size()]));
}
BENCHMARK(brute_force<Skip::nothing>)->Name("relight/brute_force/plain")->Unit(benchmark::kMicrosecond);
BENCHMARK(brute_force<Skip::unseen>)->Name("relight/brute_force/skipping")->Unit(benchmark::kMicrosecond);

/// Largest error of a node's power against the sum over its leaves, as a share of the whole.
double lighting_error(const FrameLighting& frame, std::uint32_t leaf_count) {
  double worst = 0;
  for (std::uint32_t h = 1; h < leaf_count; ++h) {
    const LeafRange leaves = leaves_below(leaf_count, h);
    glm::dvec3 sum(0);
    for (std::uint32_t i = leaves.begin; i < leaves.end; ++i)
      sum += glm::dvec3(frame.nodes[leaf_count + i].power);
    worst = std::max(worst, glm::length(glm::dvec3(frame.nodes[h].power) - sum));
  }
  return worst / double(length(frame.nodes[1].power));
}

void light_nodes(benchmark::State& state) {
  const Demo& demo = Demo::get();
  const LightTree& tree = demo.relighting.tree();
  static const auto lights = EnvironmentCells(even_directions(tree.leaf_count()), demo.environment.map.width,
                                              demo.environment.map.height)
                                 .gather(demo.environment);
  static const double error = lighting_error(demo.lighting[usual], tree.leaf_count());
  if (!agrees(state, error, 1e-5)) return;
  for (auto _ : state)
    benchmark::DoNotOptimize(light_frame(tree, lights, demo.relighting.directions(), illumination_nodes,
                                         demo.relighting.cuts(usual).granule_log2()));
}
BENCHMARK(light_nodes)->Name("relight/light_frame")->Unit(benchmark::kMicrosecond);

const std::vector<vec3>& reference_radiance() {
  static const auto radiance =
      Demo::get().relighting.shade_by_brute_force<Skip::nothing>(Demo::get().lighting[usual], Serial());
  return radiance;
}

/// Relative RMS error of an image against brute force.
double image_error(std::span<const vec3> radiance) {
  const auto& relighting = Demo::get().relighting;
  const Image image = relighting.image(radiance), truth = relighting.image(reference_radiance());
  std::vector<bool> counts;
  for (const float c : relighting.direct().coverage) counts.push_back(c > 0);
  return image_errors(image, truth, counts).rel_rmse;
}

void show_memory(benchmark::State& state, std::size_t which) {
  const auto& relighting = Demo::get().relighting;
  const double receivers = double(relighting.receivers().size());
  state.counters["bytes_per_receiver"] = double(relighting.cuts(which).byte_count()) / receivers;
  state.counters["pieces_per_receiver"] = double(relighting.cuts(which).values().size()) / receivers;
}

/// A frame from merged cuts, all points. Its error is that of the approximation; the limit tells a broken
/// image.
template <std::size_t which>
void shade_image(benchmark::State& state) {
  const Demo& demo = Demo::get();
  const auto shade = [&] {
    return demo.relighting.shade(demo.lighting[which], Serial(), which, {}, {Lobes::sampled});
  };
  static const double error = image_error(shade());
  if (!agrees(state, error, 0.1)) return;
  show_memory(state, which);
  state.counters["per_point"] = seconds_for_each(double(demo.relighting.buffer().points.size()));
  for (auto _ : state) benchmark::DoNotOptimize(shade());
}
BENCHMARK(shade_image<0>)->Name("relight/image/sigma:1")->Unit(benchmark::kMillisecond);
BENCHMARK(shade_image<1>)->Name("relight/image/sigma:2")->Unit(benchmark::kMillisecond);
BENCHMARK(shade_image<2>)->Name("relight/image/sigma:3")->Unit(benchmark::kMillisecond);

template <Skip skip>
void shade_image_by_brute_force(benchmark::State& state) {
  const Demo& demo = Demo::get();
  const auto shade = [&] {
    return demo.relighting.shade_by_brute_force<skip>(demo.lighting[usual], Serial());
  };
  static const double error = std::max(image_error(shade()), brute_force_error<skip>());
  if (!agrees(state, error, 1e-4)) return;
  state.counters["per_point"] = seconds_for_each(double(demo.relighting.buffer().points.size()));
  for (auto _ : state) benchmark::DoNotOptimize(shade());
}
BENCHMARK(shade_image_by_brute_force<Skip::nothing>)
    ->Name("relight/image_by_brute_force/plain")
    ->Unit(benchmark::kMillisecond);
BENCHMARK(shade_image_by_brute_force<Skip::unseen>)
    ->Name("relight/image_by_brute_force/skipping")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice::bench
