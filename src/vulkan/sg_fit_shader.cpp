#include <coppice/vulkan/sg_shader.hpp>
//
#include <algorithm>

#include "kept_buffer.hpp"
#include "shaders/sg_fit_means.h"
#include "shaders/sg_fit_pass.h"

namespace coppice {
namespace {

using compute::Buffer;
using compute::Memory;

static_assert(sizeof(EnvironmentCell) == sizeof(FitCell));
static_assert(offsetof(EnvironmentCell, energy) == offsetof(FitCell, energy));
static_assert(offsetof(EnvironmentCell, centre) == offsetof(FitCell, centre));

/// Passes of a loop that any driver lets an invocation make.
constexpr std::size_t most_passes = 32768;

struct MatrixBuffers {
  Buffer begins, columns, values;

  MatrixBuffers(const VulkanDevice& device, const detail::SparseRows& rows)
      : begins(compute::buffer_of(device, std::span(rows.begins))),
        columns(compute::buffer_of(device, std::span(rows.columns))),
        values(compute::buffer_of(device, std::span(rows.values))) {}
  SparseMatrix matrix() const { return {begins.address(), columns.address(), values.address()}; }
};

/// One level of a fit on the device.
struct FitLevelBuffers {
  std::uint32_t first, count;
  float window, step;
  MatrixBuffers windows, model;
  Buffer axes, means;

  FitLevelBuffers(const VulkanDevice& device, const detail::FitLevel& level)
      : first(std::uint32_t(level.first())),
        count(std::uint32_t(level.axes().size())),
        window(level.window()),
        step(level.step()),
        windows(device, level.windows()),
        model(device, level.model()),
        axes(compute::buffer_of(device, level.axes())),
        means(device, Memory::device, level.axes().size() * sizeof(vec3)) {}
};

/// Dispatches a kernel of one workgroup a row.
template <class Parameters>
void dispatch_rows(compute::Commands& commands, const compute::Kernel& kernel, const Parameters& parameters,
                   std::uint32_t count) {
  commands.dispatch(kernel, count, std::as_bytes(std::span(&parameters, 1)));
}

}  // namespace

struct SgFitShader::State {
  VulkanDevice& device;
  compute::Kernel means, pass;
  std::vector<FitLevelBuffers> levels;
  std::size_t shape_count;  ///< of all levels
  int passes;
  Buffer centres;
  KeptBuffer cells, peaks;
  std::vector<Buffer> amplitudes;  ///< before a pass and after it
  std::optional<double> milliseconds;

  State(VulkanDevice& vulkan, const EnvironmentFitter& fitter);
  void find_means(compute::Commands& commands, std::uint32_t peak_count) const;
  void solve(compute::Commands& commands, const FitLevelBuffers& level) const;
};

SgFitShader::State::State(VulkanDevice& vulkan, const EnvironmentFitter& fitter)
    : device(vulkan),
      means(device, shaders::sg_fit_means, sizeof(FitMeansParameters)),
      pass(device, shaders::sg_fit_pass, sizeof(FitPassParameters)),
      shape_count(fitter.shapes().size()),
      passes(fitter.options().passes),
      centres(compute::buffer_of(device, fitter.grid().centres())),
      cells(device),
      peaks(device) {
  for (const detail::FitLevel& level : fitter.levels()) levels.emplace_back(device, level);
  for (int i = 0; i < 2; ++i) amplitudes.emplace_back(device, Memory::device, shape_count * sizeof(vec3));
  COPPICE_ASSERT(levels.back().count <= compute::max_group_count(device));
  COPPICE_ASSERT(fitter.grid().centres().size() <= most_passes * KERNEL_GROUP_SIZE);
}

void SgFitShader::State::find_means(compute::Commands& commands, std::uint32_t peak_count) const {
  for (const FitLevelBuffers& level : levels) {
    const FitMeansParameters parameters{.windows = level.windows.matrix(),
                                        .cells = cells.address(),
                                        .centres = centres.address(),
                                        .axes = level.axes.address(),
                                        .peaks = peaks.address(),
                                        .means = level.means.address(),
                                        .sharpness = level.window,
                                        .peak_count = peak_count};
    dispatch_rows(commands, means, parameters, level.count);
  }
  commands.barrier();
}

/// Both buffers of amplitudes hold the level's in the end.
void SgFitShader::State::solve(compute::Commands& commands, const FitLevelBuffers& level) const {
  for (int i = 0; i < passes; ++i) {
    const FitPassParameters parameters{.model = level.model.matrix(),
                                       .means = level.means.address(),
                                       .from = amplitudes[std::size_t(i % 2)].address(),
                                       .to = amplitudes[std::size_t((i + 1) % 2)].address(),
                                       .step = level.step,
                                       .first_gaussian = level.first};
    dispatch_rows(commands, pass, parameters, level.count);
    commands.barrier();
  }
  const std::size_t last = std::size_t(passes % 2), begin = level.first * sizeof(vec3);
  commands.copy(amplitudes[last], begin, amplitudes[1 - last], begin, level.count * sizeof(vec3));
  commands.barrier();
}

SgFitShader::SgFitShader(VulkanDevice& device, const EnvironmentFitter& fitter)
    : fitter_(&fitter), state_(std::make_unique<State>(device, fitter)) {}
SgFitShader::~SgFitShader() = default;
SgFitShader::SgFitShader(SgFitShader&&) noexcept = default;
SgFitShader& SgFitShader::operator=(SgFitShader&&) noexcept = default;
std::optional<double> SgFitShader::milliseconds() const { return state_->milliseconds; }

std::vector<vec3> SgFitShader::solve(std::span<const EnvironmentCell> cells, std::span<const SgLight> peaks) {
  State& state = *state_;
  COPPICE_ASSERT(peaks.size() <= most_passes);
  state.cells.set(cells);
  state.peaks.set(peaks);
  compute::Commands commands(state.device);
  for (const Buffer& buffer : state.amplitudes) commands.fill_with_zeros(buffer);
  commands.barrier();
  commands.read_clock();
  state.find_means(commands, std::uint32_t(peaks.size()));
  for (const FitLevelBuffers& level : state.levels) state.solve(commands, level);
  commands.read_clock();
  commands.submit();
  state.milliseconds = commands.milliseconds();
  return compute::items_of<vec3>(state.device, state.amplitudes[0], state.shape_count);
}

}  // namespace coppice
