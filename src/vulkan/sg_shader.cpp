#include <coppice/vulkan/sg_shader.hpp>
//
#include <algorithm>
#include <limits>

#include "kept_buffer.hpp"
#include "shaders/sg_cones.h"
#include "shaders/sg_products.h"

namespace coppice {
namespace {

/// Milliseconds of a call with those of one more piece; none where the device has no clock.
std::optional<double> with(std::optional<double> total, std::optional<double> more) {
  if (more) *more += total.value_or(0);
  return more;
}

}  // namespace

struct ConeShader::State {
  VulkanDevice& device;
  ConeTracerOptions options;
  std::size_t cones_per_piece;
  compute::Kernel kernel;
  BrickGrid empty;  ///< until there is another
  const BrickGrid* grid = nullptr;
  KeptBuffer settings, slots, distances, receivers, cones, closed, visibility;
  std::optional<double> milliseconds;

  State(VulkanDevice& vulkan, const ConeTracerOptions& how, std::size_t piece)
      : device(vulkan),
        options(how),
        cones_per_piece(piece),
        kernel(device, shaders::sg_cones, sizeof(ConesParameters)),
        settings(device),
        slots(device),
        distances(device),
        receivers(device),
        cones(device),
        closed(device),
        visibility(device) {}

  std::span<const ConeReceiver> piece(std::span<const ConeReceiver> rest, std::size_t before) const;
  void march(std::span<const ConeReceiver> some, std::uint32_t before, std::span<const SgShape> shapes,
             std::span<const std::uint8_t> masks, std::span<float> result);
};

/// The first receivers of the rest, as many as have their cones in one piece; one at least.
std::span<const ConeReceiver> ConeShader::State::piece(std::span<const ConeReceiver> rest,
                                                       std::size_t before) const {
  const auto fits = [&](const ConeReceiver& r) { return r.cones_end - before <= cones_per_piece; };
  const auto count = std::size_t(std::ranges::partition_point(rest, fits) - rest.begin());
  return rest.first(std::max<std::size_t>(count, 1));
}

/// The cones of some receivers, with `before` in the batch before them.
void ConeShader::State::march(std::span<const ConeReceiver> some, std::uint32_t before,
                              std::span<const SgShape> shapes, std::span<const std::uint8_t> masks,
                              std::span<float> result) {
  ConeSettings how{grid->grid, options.trace};
  how.trace.start = std::fmax(options.trace.start, options.contact);
  settings.set(std::span<const ConeSettings>(&how, 1));
  receivers.set(some);
  cones.set(shapes);
  closed.set(masks);
  visibility.make_room(result.size_bytes());
  const ConesParameters parameters{.settings = settings.address(),
                                   .slots = slots.address(),
                                   .distances = distances.address(),
                                   .receivers = receivers.address(),
                                   .cones = cones.address(),
                                   .closed = closed.address(),
                                   .visibility = visibility.address(),
                                   .range = {},
                                   .receiver_count = std::uint32_t(some.size()),
                                   .before = before,
                                   .has_closed = masks.empty() ? 0u : 1u};
  compute::Commands commands(device);
  commands.read_clock();
  compute::dispatch_items(commands, device, kernel, parameters, std::uint32_t(shapes.size()));
  commands.read_clock();
  commands.submit();
  milliseconds = with(milliseconds, commands.milliseconds());
  compute::download(device, visibility.buffer(), std::as_writable_bytes(result));
}

ConeShader::ConeShader(VulkanDevice& device, const ConeTracerOptions& options, std::size_t cones_per_piece)
    : state_(std::make_unique<State>(device, options, cones_per_piece)) {
  COPPICE_ASSERT(cones_per_piece > 0 && options.trace.rays > 0);
  COPPICE_ASSERT(std::uint64_t(options.trace.rays) * options.trace.steps <= SG_STEPS_PER_CONE);
  set_grid(state_->empty);
}
ConeShader::~ConeShader() = default;
ConeShader::ConeShader(ConeShader&&) noexcept = default;
ConeShader& ConeShader::operator=(ConeShader&&) noexcept = default;
std::optional<double> ConeShader::milliseconds() const { return state_->milliseconds; }

void ConeShader::set_grid(const BrickGrid& grid) {
  COPPICE_ASSERT(grid.distances.size() <= std::numeric_limits<std::uint32_t>::max());
  state_->grid = &grid;
  state_->slots.set(std::span(grid.slots));
  state_->distances.set(std::span(grid.distances));
}

void ConeShader::march(std::span<const ConeReceiver> receivers, std::span<const SgShape> cones,
                       std::span<const std::uint8_t> closed, std::span<float> visibility) {
  State& state = *state_;
  COPPICE_ASSERT(closed.empty() ||
                 (closed.size() >= cones.size() && state.options.trace.rays <= SG_CONTACT_RAYS));
  COPPICE_ASSERT(visibility.size() >= cones.size());
  state.milliseconds.reset();
  for (std::size_t i = 0, before = 0; i < receivers.size();) {
    const auto some = state.piece(receivers.subspan(i), before);
    const std::size_t count = some.back().cones_end - before;
    COPPICE_ASSERT(before + count <= cones.size());
    if (count > 0)
      state.march(some, std::uint32_t(before), cones.subspan(before, count),
                  closed.empty() ? closed : closed.subspan(before, count), visibility.subspan(before, count));
    i += some.size(), before += count;
  }
}

const ConeTracerOptions& ConeShader::options() const { return state_->options; }
const BrickGrid& ConeShader::grid() const { return *state_->grid; }

struct SgProductShader::State {
  VulkanDevice& device;
  std::size_t pairs_per_piece;
  compute::Kernel kernel;
  std::uint32_t light_count = 0;
  KeptBuffer lights, pairs, means;
  std::optional<double> milliseconds;

  State(VulkanDevice& vulkan, std::size_t piece)
      : device(vulkan),
        pairs_per_piece(piece),
        kernel(device, shaders::sg_products, sizeof(ProductsParameters)),
        lights(device),
        pairs(device),
        means(device) {}

  void multiply(std::span<const SgPair> some, std::span<SgPairMean> result);
};

/// Without lights, a dispatch of none.
void SgProductShader::State::multiply(std::span<const SgPair> some, std::span<SgPairMean> result) {
  pairs.set(some);
  means.make_room(result.size_bytes());
  ProductsParameters parameters{.lights = lights.address(),
                                .pairs = pairs.address(),
                                .means = means.address(),
                                .range = {},
                                .first_light = 0,
                                .end_light = 0};
  compute::Commands commands(device);
  commands.read_clock();
  do {
    parameters.first_light = parameters.end_light;
    parameters.end_light += std::min(light_count - parameters.first_light, SG_LIGHTS_PER_DISPATCH);
    compute::dispatch_items(commands, device, kernel, parameters, std::uint32_t(some.size()));
    commands.barrier();
  } while (parameters.end_light < light_count);
  commands.read_clock();
  commands.submit();
  milliseconds = with(milliseconds, commands.milliseconds());
  compute::download(device, means.buffer(), std::as_writable_bytes(result));
}

SgProductShader::SgProductShader(VulkanDevice& device, std::size_t pairs_per_piece)
    : state_(std::make_unique<State>(device, pairs_per_piece)) {
  COPPICE_ASSERT(pairs_per_piece > 0);
}
SgProductShader::~SgProductShader() = default;
SgProductShader::SgProductShader(SgProductShader&&) noexcept = default;
SgProductShader& SgProductShader::operator=(SgProductShader&&) noexcept = default;
std::optional<double> SgProductShader::milliseconds() const { return state_->milliseconds; }

void SgProductShader::set_lights(std::span<const SgLight> lights) {
  COPPICE_ASSERT(lights.size() <= std::numeric_limits<std::uint32_t>::max());
  state_->lights.set(lights);
  state_->light_count = std::uint32_t(lights.size());
}

std::vector<SgPairMean> SgProductShader::means(std::span<const SgPair> pairs) {
  std::vector<SgPairMean> result(pairs.size());
  state_->milliseconds.reset();
  for (std::size_t i = 0; i < pairs.size(); i += state_->pairs_per_piece) {
    const std::size_t count = std::min(state_->pairs_per_piece, pairs.size() - i);
    state_->multiply(pairs.subspan(i, count), std::span(result).subspan(i, count));
  }
  return result;
}

}  // namespace coppice
