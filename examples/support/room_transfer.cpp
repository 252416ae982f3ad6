#include <support/room_transfer.hpp>
//
#include <coppice/core/error.hpp>
#include <coppice/core/stopwatch.hpp>
#ifdef COPPICE_HAS_VULKAN
#include <coppice/vulkan/transfer_shader.hpp>
#endif

namespace coppice::program {
namespace {

using nlohmann::json;

template <class Value>
class StoredTransfer : public RoomTransfer {
 public:
  StoredTransfer(LightTransfer<Value> transfer, LightBasisKind kind, const Threads& threads)
      : transfer_(std::move(transfer)), kind_(kind), threads_(threads) {}

  void indirect(const DirectLight& light, std::span<vec3> out, json& stages) const override {
    Stopwatch watch;
    std::vector<float> coefficients(3 * transfer_.coefficient_count());
    if (light.grey.empty())
      project(transfer_, light.direct, threads_, coefficients, light.colour);
    else
      project_grey(transfer_, light.grey, light.colour, threads_, coefficients);
    stages["projection"] = 1e3 * watch.lap();
    std::vector<float> weights(3 * transfer_.pattern_count());
    mix(transfer_, coefficients, threads_, weights);
    stages["transfer"] = 1e3 * watch.lap();
    expand(transfer_, weights, threads_, out);
    stages["expansion"] = 1e3 * watch.lap();
  }

  std::size_t bytes() const override { return transfer_.bytes(); }
  json summary() const override {
    return {{"basis", word_of(light_basis_words, kind_)},
            {"coefficients", transfer_.coefficient_count()},
            {"patterns", transfer_.pattern_count()},
            {"bytes", transfer_.bytes()}};
  }

 protected:
  LightTransfer<Value> transfer_;
  LightBasisKind kind_;
  const Threads& threads_;
};

#ifdef COPPICE_HAS_VULKAN
class DeviceTransfer : public StoredTransfer<std::int8_t> {
 public:
  DeviceTransfer(LightTransfer<std::int8_t> transfer, LightBasisKind kind, const Threads& threads)
      : StoredTransfer(std::move(transfer), kind, threads), shader_(device_, transfer_) {}

  /// `stages` gets those of the device's clock and, with the copies, the time of them all.
  void indirect(const DirectLight& light, std::span<vec3> out, json& stages) const override {
    Stopwatch watch;
    std::vector<vec3> coloured;
    coloured.reserve(light.grey.size());
    for (const float grey : light.grey) coloured.push_back(grey * light.colour);
    shader_.indirect(light.grey.empty() ? std::span(light.direct) : std::span<const vec3>(coloured), out,
                     light.colour);
    stages["indirect"] = 1e3 * watch.lap();
    const auto times = shader_.times();
    if (!times) return;
    stages["device_projection"] = times->projection;
    stages["device_transfer"] = times->mix;
    stages["device_expansion"] = times->expansion;
  }
  json summary() const override {
    json j = StoredTransfer::summary();
    j["device"] = device_.name();
    return j;
  }

 private:
  VulkanDevice device_;
  mutable LightTransferShader shader_;
};
#endif

LightBasis basis_of(const RoomTransferOptions& o, const ClusteredSamples& samples, const RoomSolver& solver,
                    const Rows& examples, const Threads& threads) {
  LightBasisOptions basis;
  basis.rank = o.rank;
  if (o.basis != LightBasisKind::transport_aware)
    return principal_light_basis(samples, examples, o.basis, threads, basis);
  TransportProbesOptions probes;
  probes.seed = o.seed;
  return transport_aware_basis(
      samples, examples, transport_probes(solver.transport, solver.albedos, threads, probes), threads, basis);
}

}  // namespace

RoomSolver::RoomSolver(const Scene& scene, const ClusteredSamples& samples, const RoomTransferOptions& o,
                       const EmbreeTracer& tracer, const Threads& threads)
    : albedos(albedos_of(samples.samples)) {
  const SampleLookup lookup(samples.samples, SampleReach{.distance = 4 * sample_spacing(samples.samples)});
  transport =
      build_transport(scene.mesh, samples.samples, lookup, tracer, threads, {.rays = o.rays, .seed = o.seed});
  options.bounces = o.bounces;
  if (!o.tail) return;
  tail = interreflection_tail(transport, albedos, threads, o.bounces);
  options.tail = tail;
}

std::vector<vec3> RoomSolver::solve(std::span<const vec3> direct, const Threads& threads) const {
  Rows rows(direct.size(), 3);
  for (std::size_t i = 0; i < direct.size(); ++i)
    for (int c = 0; c < 3; ++c) rows[i][std::size_t(c)] = direct[i][c];
  const Rows solved = interreflect(transport, albedos, rows, threads, options);
  std::vector<vec3> indirect;
  for (std::size_t i = 0; i < direct.size(); ++i)
    indirect.emplace_back(solved[i][0], solved[i][1], solved[i][2]);
  return indirect;
}

StoredLightTransfer find_room_transfer(const RoomTransferOptions& o, const ClusteredSamples& samples,
                                       const RoomSolver& solver, std::span<const vec3> lights,
                                       const EmbreeTracer& tracer, const Threads& threads, json& seconds) {
  Stopwatch watch;
  const Rows examples =
      example_lights(samples.samples, lights, tracer, threads, softening_distance(samples.samples));
  seconds["example_lights"] = watch.lap();
  const LightBasis basis = basis_of(o, samples, solver, examples, threads);
  seconds["light_basis"] = watch.lap();
  TransferMatrixOptions options;
  options.bounces = solver.options;
  const Rows matrix = transfer_matrix(solver.transport, samples, basis, threads, options);
  seconds["transfer_matrix"] = watch.lap();
  CompressionOptions compression;
  compression.rank = o.receiver_rank;
  StoredLightTransfer transfer;
  if (o.bits == 16)
    transfer = compress_transfer<std::int16_t>(samples, basis, matrix, examples, threads, compression);
  else
    transfer = compress_transfer<std::int8_t>(samples, basis, matrix, examples, threads, compression);
  seconds["compression"] = watch.lap();
  return transfer;
}

void check_backend(const RoomTransferOptions& options, const std::string& backend) {
  if (backend != "cpu" && options.bits != 8)
    throw InputError("--backend " + backend, "has only a transfer of 8 bits",
                     "use --transfer-bits 8, or --backend cpu");
}

std::unique_ptr<RoomTransfer> make_room_transfer(const RoomTransferOptions& o, StoredLightTransfer transfer,
                                                 const Threads& threads, const std::string& backend) {
  check_backend(o, backend);
  return std::visit(
      [&]<class Value>(LightTransfer<Value>& found) -> std::unique_ptr<RoomTransfer> {
#ifdef COPPICE_HAS_VULKAN
        if constexpr (std::same_as<Value, std::int8_t>)
          if (backend == "vulkan")
            return std::make_unique<DeviceTransfer>(std::move(found), o.basis, threads);
#endif
        return std::make_unique<StoredTransfer<Value>>(std::move(found), o.basis, threads);
      },
      transfer);
}

}  // namespace coppice::program
