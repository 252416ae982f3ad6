#include <coppice/vulkan/transfer_shader.hpp>
//
#include <algorithm>

#include "shaders/sample_light.h"
#include "transfer_state.hpp"

namespace coppice {
namespace {

SampleLight sample_light(const LocalLight& light, float softening) {
  return {.position = light.position,
          .w = light.w,
          .axis = light.axis,
          .offset = light.offset,
          .intensity = light.intensity,
          .square = light.square,
          .softness = light.area / pi,
          .softening = softening > 0 ? softening * softening : 0};
}

std::vector<vec3> of_all(std::span<const SurfaceSample> samples, vec3 SurfaceSample::*member) {
  std::vector<vec3> result;
  result.reserve(samples.size());
  for (const SurfaceSample& sample : samples) result.push_back(sample.*member);
  return result;
}

/// The points of all lights one after the other, the lights, and the largest number of points.
struct PlacedLights {
  std::vector<LatticeCorners> corners;
  std::vector<SampleLight> lights;
  std::size_t most_points = 0;
  vec3 intensity{0};

  PlacedLights(std::span<const PlacedLight> placed, float softening) {
    for (const PlacedLight& p : placed) {
      corners.insert(corners.end(), p.points.begin(), p.points.end());
      lights.push_back(sample_light(p.light, softening));
      most_points = std::max(most_points, p.points.size());
      intensity += p.light.intensity;
    }
  }
  std::size_t corner_bytes() const { return corners.size() * sizeof(LatticeCorners); }
  std::size_t light_bytes() const { return lights.size() * sizeof(SampleLight); }
};

}  // namespace

struct LightFrameShader::State {
  VulkanDevice& device;
  LatticeVisibilityShader::State& visibility;
  LightTransferShader::State& transfer;
  compute::Kernel kernel;
  compute::Buffer positions, normals;
  float softening;
  KeptBuffer lights, up, down;
  std::optional<LightFrameTimes> times;

  State(VulkanDevice& vulkan, LatticeVisibilityShader::State& seen, LightTransferShader::State& transferred,
        std::span<const SurfaceSample> samples, float soft)
      : device(vulkan),
        visibility(seen),
        transfer(transferred),
        kernel(device, shaders::sample_light, sizeof(SampleLightParameters)),
        positions(compute::buffer_of<vec3>(device, of_all(samples, &SurfaceSample::position))),
        normals(compute::buffer_of<vec3>(device, of_all(samples, &SurfaceSample::normal))),
        softening(soft),
        lights(device),
        up(device, compute::Memory::upload),
        down(device, compute::Memory::download) {
    COPPICE_ASSERT(samples.size() == visibility.sample_count && samples.size() == transfer.sample_count);
  }

  void make_room(const PlacedLights& placed, std::size_t down_bytes);
  void record_lights(compute::Commands& commands, std::span<const PlacedLight> placed, LatticeShadow shadow);
};

/// Before anything is recorded, since commands hold the buffers' addresses.
void LightFrameShader::State::make_room(const PlacedLights& placed, std::size_t down_bytes) {
  visibility.make_room(placed.most_points);
  visibility.corners.make_room(placed.corner_bytes());
  lights.make_room(placed.light_bytes());
  up.make_room(placed.corner_bytes() + placed.light_bytes());
  down.make_room(down_bytes);
}

/// The direct light of all of them, into that of the transfer.
void LightFrameShader::State::record_lights(compute::Commands& commands, std::span<const PlacedLight> placed,
                                            LatticeShadow shadow) {
  std::uint32_t first_point = 0;
  SampleLightParameters parameters{.positions = positions.address(),
                                   .normals = normals.address(),
                                   .visibility = visibility.visibility.address(),
                                   .lights = lights.address(),
                                   .direct = transfer.direct.address(),
                                   .range = {},
                                   .light = 0,
                                   .continues = 0};
  for (const PlacedLight& light : placed) {
    visibility.record(commands, light.points, first_point, shadow);
    compute::dispatch_items(commands, device, kernel, parameters, transfer.sample_count);
    commands.barrier();
    first_point += std::uint32_t(light.points.size());
    ++parameters.light, parameters.continues = 1;
  }
}

LightFrameShader::LightFrameShader(VulkanDevice& device, LatticeVisibilityShader& visibility,
                                   LightTransferShader& transfer, std::span<const SurfaceSample> samples,
                                   float softening)
    : state_(std::make_unique<State>(device, *visibility.state_, *transfer.state_, samples, softening)) {}
LightFrameShader::~LightFrameShader() = default;
LightFrameShader::LightFrameShader(LightFrameShader&&) noexcept = default;
LightFrameShader& LightFrameShader::operator=(LightFrameShader&&) noexcept = default;
std::optional<LightFrameTimes> LightFrameShader::times() const { return state_->times; }

bool LightFrameShader::light(std::span<const PlacedLight> lights, LatticeShadow shadow,
                             std::span<vec3> indirect, std::span<vec3> direct) {
  State& state = *state_;
  const std::size_t count = state.transfer.sample_count;
  COPPICE_ASSERT(indirect.size() == count && (direct.empty() || direct.size() == count));
  state.times.reset();
  if (!std::ranges::all_of(lights, [](const PlacedLight& l) { return is_served(l.points); })) return false;
  if (lights.empty() || count == 0) {
    std::ranges::fill(indirect, vec3(0));
    std::ranges::fill(direct, vec3(0));
    return true;
  }
  const PlacedLights placed(lights, state.softening);
  state.make_room(placed, indirect.size_bytes() + direct.size_bytes());
  compute::Commands commands(state.device);
  stage<LatticeCorners>(commands, placed.corners, state.up, 0, state.visibility.corners.buffer());
  stage<SampleLight>(commands, placed.lights, state.up, placed.corner_bytes(), state.lights.buffer());
  commands.barrier();
  commands.read_clock();
  state.record_lights(commands, lights, shadow);
  commands.read_clock();
  state.transfer.record(commands, placed.intensity);
  commands.copy(state.transfer.indirect, 0, state.down.buffer(), 0, indirect.size_bytes());
  commands.copy(state.transfer.direct, 0, state.down.buffer(), indirect.size_bytes(), direct.size_bytes());
  commands.submit();
  if (const auto laps = commands.laps(); !laps.empty()) state.times = {laps[0], laps[1], laps[2], laps[3]};
  fetch(state.down, 0, indirect);
  fetch(state.down, indirect.size_bytes(), direct);
  return true;
}

}  // namespace coppice
