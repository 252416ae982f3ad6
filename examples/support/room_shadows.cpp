#include <coppice/core/simd.hpp>
//
#include <coppice/core/error.hpp>
#include <coppice/core/stopwatch.hpp>
#include <coppice/transfer/decisions.hpp>
#include <coppice/transfer/free_space.hpp>
#include <coppice/transfer/lattice_fit.hpp>
#include <coppice/transfer/sample_lookup.hpp>
#include <support/room_shadows.hpp>
#ifdef COPPICE_HAS_VULKAN
#include <coppice/vulkan/transfer_shader.hpp>
#endif

namespace coppice::program {
namespace {

using nlohmann::json;

class RayShadows : public RoomShadows {
 public:
  RayShadows(const ClusteredSamples& samples, const EmbreeTracer& tracer, const Threads& threads)
      : samples_(samples), tracer_(tracer), threads_(threads) {}

  void see(const SizedLight& light, std::uint32_t points, std::span<float> out) const override {
    exact_visibility(samples_.samples, points_of(light, points), tracer_, threads_, out);
  }
  std::size_t bytes() const override { return 0; }
  json summary() const override { return {{"kind", "rays"}, {"bytes", 0}}; }

 private:
  const ClusteredSamples& samples_;
  const EmbreeTracer& tracer_;
  const Threads& threads_;
};

template <class Integer>
class LatticeShadows : public RoomShadows {
 public:
  LatticeShadows(LatticeVisibility<Integer> lattice, LatticeShadow shadow, const ClusteredSamples& samples,
                 const EmbreeTracer& tracer, const Threads& threads)
      : lattice_(std::move(lattice)),
        shadow_(shadow),
        tracer_(tracer),
        threads_(threads),
        rays_(samples, tracer, threads) {}

  /// By rays where the lattice does not reach.
  void see(const SizedLight& light, std::uint32_t points, std::span<float> out) const override {
    if (!lattice_visibility(lattice_, light, shadow_, tracer_, threads_, out, points))
      rays_.see(light, points, out);
  }
  std::size_t bytes() const override { return lattice_.bytes(); }
  json summary() const override {
    return {{"kind", "lattice"},
            {"rank", lattice_.rank},
            {"bytes", lattice_.bytes()},
            {"points", lattice_.lattice.count()},
            {"spacing", lattice_.lattice.spacing}};
  }

 protected:
  LatticeVisibility<Integer> lattice_;
  LatticeShadow shadow_;
  const EmbreeTracer& tracer_;
  const Threads& threads_;
  RayShadows rays_;
};

#ifdef COPPICE_HAS_VULKAN
class DeviceShadows : public LatticeShadows<std::int8_t> {
 public:
  DeviceShadows(LatticeVisibility<std::int8_t> lattice, LatticeShadow shadow, const ClusteredSamples& samples,
                const EmbreeTracer& tracer, const Threads& threads)
      : LatticeShadows(std::move(lattice), shadow, samples, tracer, threads), shader_(device_, lattice_) {}

  void see(const SizedLight& light, std::uint32_t points, std::span<float> out) const override {
    const auto corners =
        corners_of(lattice_.lattice, std::span<const LocalLight>(points_of(light, points)), tracer_);
    if (!shader_.visibility(corners, shadow_, out)) rays_.see(light, points, out);
  }
  json summary() const override {
    json j = LatticeShadows::summary();
    j["device"] = device_.name();
    return j;
  }

 private:
  VulkanDevice device_;
  mutable LatticeVisibilityShader shader_;
};
#endif

template <class Integer>
class DepthShadows : public RoomShadows {
 public:
  DepthShadows(const ClusteredSamples& samples, const EmbreeTracer& tracer, const FreeCells* cells,
               const DepthOptions& options, const Threads& threads)
      : depth_(samples, tracer, cells, options, threads), threads_(threads) {}

  void see(const SizedLight& light, std::uint32_t points, std::span<float> out) const override {
    depth_.visibility(light, threads_, out, points);
  }
  std::size_t bytes() const override { return depth_.bytes(); }
  json summary() const override {
    return {{"kind", "depth"},
            {"rank", depth_.rank()},
            {"bytes", depth_.bytes()},
            {"directions", depth_.options().directions},
            {"limit", depth_.options().limit}};
  }

 private:
  DepthVisibility<Integer> depth_;
  const Threads& threads_;
};

/// What making shadows needs.
struct Room {
  const RoomShadowOptions& options;
  const ClusteredSamples& samples;
  std::span<const Flight> flights;
  const EmbreeTracer& tracer;
  const Threads& threads;
  json& seconds;
  std::string backend = "cpu";

  /// Lights that may stand anywhere in the free space; other than those of sweeps.
  std::vector<vec3> lights(std::size_t count) const {
    return free_positions(flights, count, 0x5eed ^ options.seed);
  }
};

template <class Integer>
LatticeVisibility<Integer> fit_lattice(const Room& room) {
  Stopwatch watch;
  constexpr std::size_t positions_a_point = 32;
  const RoomShadowOptions& o = room.options;
  LightLattice lattice =
      light_lattice_within(room.lights(positions_a_point * o.lattice_points), o.lattice_points, room.tracer);
  const std::vector<vec3> training = room.lights(o.training * lattice.count());
  DecisionOptions fit;
  fit.rank = o.rank_in_force();
  auto visibility = fit_lattice_visibility<Integer>(room.samples, std::move(lattice), training, room.tracer,
                                                    room.threads, fit);
  room.seconds["visibility"] = watch.lap();
  return visibility;
}

template <class Integer>
std::unique_ptr<RoomShadows> make_depth(const Room& room) {
  Stopwatch watch;
  const RoomShadowOptions& o = room.options;
  DepthOptions depth;
  depth.directions = o.dome == Dome::sphere ? 2 * o.directions : o.directions;
  depth.dome = o.dome, depth.rank = o.rank_in_force(), depth.rounds = o.intervals;
  // Measured: plain components err by so much of the distance, intervals leave their bias as it is.
  if (o.intervals == 0) depth.bias = 0.47f / std::sqrt(float(std::max<std::size_t>(depth.rank, 4)));
  const float reach = light_reach(room.samples.samples, room.lights(1000));
  if (std::isfinite(reach)) depth.limit = reach;
  std::optional<FreeCells> cells;
  if (o.intervals > 0 && !room.flights.empty())
    cells = free_cells(room.flights, sample_spacing(room.samples.samples));
  auto shadows = std::make_unique<DepthShadows<Integer>>(room.samples, room.tracer, cells ? &*cells : nullptr,
                                                         depth, room.threads);
  room.seconds["visibility"] = watch.lap();
  return shadows;
}

/// Serves what was fitted, or read from a store.
struct MakeShadows {
  const Room& room;

  std::unique_ptr<RoomShadows> operator()(std::monostate) const {
    return std::make_unique<RayShadows>(room.samples, room.tracer, room.threads);
  }
  template <class Integer>
  std::unique_ptr<RoomShadows> operator()(LatticeVisibility<Integer>& lattice) const {
#ifdef COPPICE_HAS_VULKAN
    if constexpr (std::same_as<Integer, std::int8_t>)
      if (room.backend == "vulkan")
        return std::make_unique<DeviceShadows>(std::move(lattice), room.options.shadow, room.samples,
                                               room.tracer, room.threads);
#endif
    return std::make_unique<LatticeShadows<Integer>>(std::move(lattice), room.options.shadow, room.samples,
                                                     room.tracer, room.threads);
  }
};

}  // namespace

StoredLightVisibility fit_room_visibility(const RoomShadowOptions& options, const ClusteredSamples& samples,
                                          std::span<const Flight> flights, const EmbreeTracer& tracer,
                                          const Threads& threads, json& seconds) {
  if (options.kind != RoomVisibility::lattice) return std::monostate();
  const Room room{options, samples, flights, tracer, threads, seconds};
  if (options.bits == 16) return fit_lattice<std::int16_t>(room);
  return fit_lattice<std::int8_t>(room);
}

void check_backend(const RoomShadowOptions& options, const std::string& backend) {
  if (backend == "cpu") return;
  if (options.kind != RoomVisibility::lattice)
    throw InputError("--backend " + backend, "has only the visibility of the lattice",
                     "use --visibility lattice, or --backend cpu");
  if (options.bits != 8)
    throw InputError("--backend " + backend, "has only visibility of 8 bits",
                     "use --visibility-bits 8, or --backend cpu");
}

std::unique_ptr<RoomShadows> make_room_shadows(const RoomShadowOptions& options,
                                               StoredLightVisibility visibility,
                                               const ClusteredSamples& samples,
                                               std::span<const Flight> flights, const EmbreeTracer& tracer,
                                               const Threads& threads, json& seconds,
                                               const std::string& backend) {
  check_backend(options, backend);
  const Room room{options, samples, flights, tracer, threads, seconds, backend};
  if (options.kind == RoomVisibility::depth)
    return options.bits == 16 ? make_depth<std::int16_t>(room) : make_depth<std::int8_t>(room);
  return std::visit(MakeShadows{room}, visibility);
}

}  // namespace coppice::program
