// Precomputing visibility, against the shadow rays that it cannot do without.
#include <coppice/core/stopwatch.hpp>

#include "check.hpp"
#include "demo.hpp"

namespace coppice::bench {
namespace {

/// All shadow packets of one receiver, ready to be traced.
struct ReadyPackets {
  std::vector<ShadowPacket> packets;
  std::vector<std::uint32_t> lanes;

  ReadyPackets(const DirectionPackets& lights, const Receiver& receiver) {
    for (std::uint32_t p = 0; p < lights.packet_count(); ++p) {
      lanes.push_back(lights.worth_tracing(p, receiver));
      packets.push_back(packet_from(receiver.position));
      lights.aim(p, receiver.position, packets.back());
    }
  }
};

/// Seconds in the calls that trace the receivers' rays, and in nothing else.
double seconds_of_rays(const EmbreeTracer& tracer, const DirectionPackets& lights,
                       std::span<const Receiver> receivers) {
  double seconds = 0;
  for (const Receiver& receiver : receivers) {
    const ReadyPackets ready(lights, receiver);
    const Stopwatch watch;
    for (std::size_t p = 0; p < ready.packets.size(); ++p)
      if (ready.lanes[p] != 0) benchmark::DoNotOptimize(tracer.occluded(ready.packets[p], ready.lanes[p]));
    seconds += watch.seconds();
  }
  return seconds;
}

/// Share of leaves whose visibility is not what single rays say. They take another path through Embree, so
/// that a ray that grazes an edge may differ.
double visibility_error(const EmbreeTracer& tracer, const DirectionPackets& lights,
                        std::span<const Receiver> receivers, std::span<const std::uint64_t> bits) {
  std::size_t wrong = 0, rays = 0;
  for (std::size_t r = 0; r < receivers.size(); ++r)
    for (std::uint32_t i = 0; i < lights.count(); i += 7, ++rays) {
      const vec3 d = lights.direction(i);
      const bool above = dot(receivers[r].normal, d) > receivers[r].horizon;
      const bool visible =
          above && !tracer.occluded(receivers[r].position, d, std::numeric_limits<float>::infinity());
      wrong += visible != bit_at(bits.data() + r * words_for_bits(lights.count()), i);
    }
  return double(wrong) / double(rays);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The two are timed in turn, so that what else the machine does falls on both; the counter is the median
/// ratio.
void precompute(benchmark::State& state) {
  const Demo& demo = Demo::get();
  const LightTree& tree = demo.relighting.tree();
  const DirectionPackets lights(leaf_directions(tree, demo.relighting.directions()));
  std::vector<Receiver> receivers;
  for (const std::uint32_t r : spread_indices(32, demo.relighting.receivers().size()))
    receivers.push_back(demo.relighting.receivers()[r]);
  const std::vector<VisibilityCutOptions> options{demo.relighting.options().cuts[usual]};
  const auto run = [&](bool keep_bits) {
    return precompute_visibility<std::uint8_t>(demo.tracer, tree, lights, receivers, options, keep_bits,
                                               Serial());
  };
  const auto checked = run(true);
  if (!agrees(state, visibility_error(demo.tracer, lights, receivers, checked.bits), 1e-4)) return;
  std::vector<double> ratios;
  for (auto _ : state) {
    const double rays = seconds_of_rays(demo.tracer, lights, receivers);
    const Stopwatch watch;
    benchmark::DoNotOptimize(run(false));
    state.SetIterationTime(watch.seconds());
    ratios.push_back(watch.seconds() / rays);
  }
  state.counters["times_bare_rays"] = median(ratios);
  state.counters["per_ray"] = seconds_for_each(double(checked.rays));
}
BENCHMARK(precompute)->Name("embree/precompute_visibility")->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice::bench
