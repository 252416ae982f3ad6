// Relighting by spherical Gaussians: light at cones, cones at points, and how much of them is visible.
#include <coppice/core/simd.hpp>
//
#include <coppice/core/random.hpp>
#include <coppice/sg/cone_cut.hpp>
#include <coppice/sg/environment_fit.hpp>
#include <coppice/sg/preconvolved.hpp>
#include <coppice/sg/ray_cones.hpp>
#include <coppice/sg/sky_lights.hpp>
#include <coppice/voxel/brick_builder.hpp>
#include <coppice/voxel/cone_tracer.hpp>
#include <optional>

#include "check.hpp"
#include "demo.hpp"

namespace coppice::bench {
namespace {

const EnvironmentFit& fit() {
  static const EnvironmentFit made = [] {
    const Environment& e = Demo::get().environment;
    return EnvironmentFitter({}, e.map.width, e.map.height).fit(e);
  }();
  return made;
}

/// Gaussians of cones, anywhere.
const std::vector<SgShape>& shapes() {
  static const std::vector<SgShape> made = [] {
    Random random(1);
    std::vector<SgShape> all;
    for (int i = 0; i < 1024; ++i) all.push_back({random.direction(), std::exp(5 * random.uniform())});
    return all;
  }();
  return made;
}

template <class Mean>
std::vector<vec3> means(Mean&& mean) {
  std::vector<vec3> result;
  for (const SgShape& s : shapes()) result.push_back(mean(s));
  return result;
}

/// One light after the other.
vec3 slow_mean(const SgShape& s) {
  vec3 sum(0);
  for (const SgLight& l : fit().rest())
    sum += sg_normalisation(s.sharpness) * sg_inner_product(s, {l.axis, l.sharpness}) * l.amplitude;
  return sum;
}

void by_all_lights(benchmark::State& state) {
  detail::LightColumns columns;
  for (const SgLight& light : fit().rest()) columns.append(light);
  columns.pad();
  const auto run = [&] { return means([&](const SgShape& s) { return columns.mean(s.axis, s.sharpness); }); };
  if (!agrees(state, relative_difference(run(), means(slow_mean)), 1e-4)) return;
  for (auto _ : state) benchmark::DoNotOptimize(run());
  state.counters["cone"] = seconds_for_each(double(shapes().size()));
}
BENCHMARK(by_all_lights)->Name("sg/light_by_all_gaussians")->Unit(benchmark::kMillisecond);

void by_culled_lights(benchmark::State& state) {
  detail::LightColumns columns;
  for (const SgLight& light : fit().rest()) columns.append(light);
  columns.pad();
  const auto run = [&] {
    return means([&](const SgShape& s) { return columns.mean(s.axis, s.sharpness, 1e-3f); });
  };
  if (!agrees(state, relative_difference(run(), means(slow_mean)), 1e-3)) return;
  for (auto _ : state) benchmark::DoNotOptimize(run());
  state.counters["cone"] = seconds_for_each(double(shapes().size()));
}
BENCHMARK(by_culled_lights)->Name("sg/light_by_gaussians_that_matter")->Unit(benchmark::kMillisecond);

void by_lookup(benchmark::State& state) {
  const PreconvolvedEnvironment table(fit().rest());
  const auto run = [&] { return means([&](const SgShape& s) { return table.mean(s); }); };
  if (!agrees(state, relative_difference(run(), means(slow_mean)), 0.05)) return;
  for (auto _ : state) benchmark::DoNotOptimize(run());
  state.counters["cone"] = seconds_for_each(double(shapes().size()));
}
BENCHMARK(by_lookup)->Name("sg/light_by_lookup")->Unit(benchmark::kMillisecond);

/// The demo's light as cones see it, and points of the demo.
struct Relit {
  SkyLights sky{SkyOptions{}};
  ProductTree tree;
  std::vector<ShadingPoint> points;
  std::vector<ConeReceiver> receivers;
  ConeBatch batch;
  BrickGrid grid;

  Relit() {
    const Demo& demo = Demo::get();
    sky.take(demo.environment.map);
    tree = ProductTree(sky.lighting(), sky.parts().peaks);
    const auto& buffer = demo.relighting.buffer();
    for (const std::uint32_t p : spread_indices(2000, buffer.points.size())) {
      points.push_back(buffer.points[p]);
      const vec3 n = buffer.points[p].normal;
      receivers.push_back({buffer.positions[p], 0, n, p, n});
    }
    batch = place();
    BrickBuilder voxels(box_of(demo.scene.mesh), 256);
    voxels.build(demo.scene.mesh, Serial{});
    grid = voxels.grid();
  }

  static VoxelBox box_of(const Mesh& mesh) {
    VoxelBox box{mesh.positions[0], mesh.positions[0]};
    for (const vec3& p : mesh.positions) box.low = glm::min(box.low, p), box.high = glm::max(box.high, p);
    return box;
  }

  struct Placer {
    const std::vector<ShadingPoint>& points;
    ConeCut cut;
    const LitCones& place(std::size_t i) { return cut.place(points[i]); }
  };
  ConeBatch place() const {
    return place_cones(
        receivers,
        [&] {
          return Placer{points, ConeCut(tree)};
        },
        Serial{});
  }

  template <class Tracer>
  std::vector<vec3> radiance(Tracer&& trace) const {
    std::vector<float> visibility(batch.cones.size());
    trace(visibility);
    return visible_light(batch, visibility, Serial{});
  }
};

const Relit& relit() {
  static const Relit made;
  return made;
}

void place(benchmark::State& state) {
  const Relit& r = relit();
  const std::vector<float> open(r.batch.cones.size(), 1.0f);
  const std::vector<vec3> placed = visible_light(r.batch, open, Serial{});
  std::vector<vec3> fine;  // the same from sixteen times as many nodes
  const FrameLighting frame = [&] {
    SkyOptions options;
    options.pieces = 4096;
    SkyLights sky(options);
    sky.take(Demo::get().environment.map);
    return sky.lighting();
  }();
  const ProductTree tree(frame, r.sky.parts().peaks);
  ConeCut cut(tree, {.lobe_tolerance = 1e-5f});
  for (const ShadingPoint& p : r.points) fine.push_back(cut.place(p).unoccluded());
  if (!agrees(state, relative_difference(placed, fine), 0.02)) return;
  for (auto _ : state) benchmark::DoNotOptimize(r.place());
  state.counters["point"] = seconds_for_each(double(r.points.size()));
}
BENCHMARK(place)->Name("sg/cones_by_cut")->Unit(benchmark::kMillisecond);

/// With as many rays that they are all but exact.
const std::vector<vec3>& exact() {
  static const std::vector<vec3> made = relit().radiance([](std::span<float> visibility) {
    RayCones(Demo::get().tracer, 512)
        .trace(relit().batch.receivers, relit().batch.shapes, visibility, Serial{});
  });
  return made;
}

template <class Tracer>
void measure_tracing(benchmark::State& state, double limit, Tracer&& trace) {
  if (!agrees(state, relative_difference(relit().radiance(trace), exact()), limit)) return;
  std::vector<float> visibility(relit().batch.cones.size());
  for (auto _ : state) {
    trace(visibility);
    benchmark::DoNotOptimize(visibility.data());
  }
  state.counters["cone"] = seconds_for_each(double(relit().batch.cones.size()));
}

void by_voxels(benchmark::State& state) {
  const ConeTracer tracer(relit().grid, {.contact = float(state.range(0))});
  measure_tracing(state, 0.15, [&](std::span<float> visibility) {
    tracer.trace(Demo::get().tracer, relit().batch.receivers, relit().batch.shapes, visibility, Serial{});
  });
}
BENCHMARK(by_voxels)->Name("sg/visibility_by_voxels_contact")->Arg(3)->Arg(0)->Unit(benchmark::kMillisecond);

void by_rays(benchmark::State& state) {
  const RayCones rays(Demo::get().tracer, std::uint32_t(state.range(0)));
  measure_tracing(state, 0.1, [&](std::span<float> visibility) {
    rays.trace(relit().batch.receivers, relit().batch.shapes, visibility, Serial{});
  });
}
BENCHMARK(by_rays)->Name("sg/visibility_by_rays")->Arg(16)->Arg(64)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice::bench
