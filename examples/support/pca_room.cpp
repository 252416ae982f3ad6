#include <support/pca_room.hpp>
//
#include <coppice/core/stopwatch.hpp>
#include <coppice/transfer/free_space.hpp>
#include <support/light_path.hpp>
#include <support/room_store.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

constexpr std::size_t candidates_a_room_sample = 6;

ParticleField particles(const PcaRoomOptions& o, const Scene& scene, const vec3& eye,
                        const EmbreeTracer& tracer, const Threads& threads, std::size_t count,
                        std::uint64_t seed) {
  std::vector<vec3> starts;
  for (const std::string& text : o.starts) starts.push_back(parse_vector("--start", text));
  if (starts.empty()) starts.push_back(eye);
  ParticleOptions options;
  options.count = count, options.seed = seed, options.shading = o.shading;
  return trace_particles(scene, tracer, starts, threads, options);
}

}  // namespace

RoomSamples make_room_samples(const PcaRoomOptions& o, const Scene& scene, const vec3& eye,
                              const EmbreeTracer& tracer, const Threads& threads, json& seconds) {
  Stopwatch watch;
  RoomSamples room;
  room.field = particles(o, scene, eye, tracer, threads, candidates_a_room_sample * o.samples.count, o.seed);
  seconds["particles"] = watch.lap();
  const auto samples = room_samples(room.field.candidates, threads, o.samples);
  seconds["samples"] = watch.lap();
  room.clustered = cluster_samples(samples, threads, o.clusters);
  seconds["clusters"] = watch.lap();
  const ParticleField fresh = particles(o, scene, eye, tracer, threads, 20000, o.seed + 1000003);
  const auto radius =
      float(radius_for_samples(room.field.area, double(std::max<std::size_t>(samples.size(), 1))));
  room.coverage = coverage(room.clustered, room.field, fresh.candidates, radius, threads);
  seconds["coverage"] = watch.lap();
  return room;
}

json coverage_json(const CoverageReport& c) {
  return {{"samples", c.samples},
          {"area", c.area},
          {"spacing", c.spacing},
          {"nearest_mean", c.nearest_mean},
          {"nearest_deviation", c.nearest_deviation},
          {"nearest_min", c.nearest_min},
          {"nearest_max", c.nearest_max},
          {"beyond_radius", c.beyond_radius},
          {"particles", c.traced},
          {"escaped", c.escaped},
          {"stray", c.stray},
          {"clusters", c.clusters},
          {"cluster_sizes", {c.smallest_cluster, c.median_cluster, c.largest_cluster}}};
}

PcaRoom::PcaRoom(const PcaRoomOptions& o, const Scene& scene, const vec3& eye, const EmbreeTracer& tracer,
                 const Threads& threads, const std::filesystem::path& store)
    : options_(o), scene_(scene), tracer_(tracer), threads_(threads) {
  RoomStore file(store, o, scene, eye);
  Stopwatch watch;
  auto known = file.read();
  if (known) {
    samples.clustered = std::move(known->samples);
    seconds["read"] = watch.lap();
  } else {
    known = compute(eye);
    watch.lap();
    if (file.is_used()) file.write(samples.clustered, *known), seconds["write"] = watch.lap();
  }
  store_note = file.note();
  shadows = make_room_shadows(o.shadows, std::move(known->visibility), samples.clustered,
                              samples.field.flights, tracer, threads, seconds, o.backend);
  transfer = make_room_transfer(o.transfer, std::move(known->transfer), threads, o.backend);
}

/// Samples stay here; the rest is returned.
StoredRoom PcaRoom::compute(const vec3& eye) {
  samples = make_room_samples(options_, scene_, eye, tracer_, threads_, seconds);
  const auto& flights = samples.field.flights;
  StoredRoom room;
  room.visibility =
      fit_room_visibility(options_.shadows, samples.clustered, flights, tracer_, threads_, seconds);
  const auto lights = free_positions(flights, options_.transfer.example_lights, options_.seed ^ 0x11947);
  room.transfer =
      find_room_transfer(options_.transfer, samples.clustered, solver(), lights, tracer_, threads_, seconds);
  return room;
}

const RoomSolver& PcaRoom::solver() {
  if (!solver_) {
    Stopwatch watch;
    solver_.emplace(scene_, samples.clustered, options_.transfer, tracer_, threads_);
    seconds["transport"] = watch.lap();
  }
  return *solver_;
}

json PcaRoom::summary() const {
  const ClusteredSamples& clustered = samples.clustered;
  json j = {{"samples", samples.coverage
                            ? coverage_json(*samples.coverage)
                            : json{{"samples", clustered.size()}, {"clusters", clustered.cluster_count()}}},
            {"visibility", shadows->summary()},
            {"transfer", transfer->summary()},
            {"bytes", shadows->bytes() + transfer->bytes()},
            {"seconds", seconds}};
  if (solver_) j["transport_bytes"] = solver_->transport.bytes();
  if (!store_note.empty()) j["store"] = store_note;
  return j;
}

}  // namespace coppice::program
