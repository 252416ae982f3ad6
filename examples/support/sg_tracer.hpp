// What tells how much of a frame's cones is visible: voxels, on this processor or a Vulkan device, or rays.
#pragma once

#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/sg/lit_cones.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <support/sg_options.hpp>

namespace coppice::program {

class SgTracer {
 public:
  virtual ~SgTracer() = default;
  /// Takes the triangles of the first frame.
  virtual void build(const Mesh&) {}
  /// Takes those of another, of which the first `resting` are where they were. Adds to `stages`.
  virtual void update(const Mesh&, std::size_t /*resting*/, nlohmann::json& /*stages*/) {}
  /// Visibility of all cones of the batch. Adds to `stages`.
  virtual std::vector<float> trace(const EmbreeTracer& tracer, const ConeBatch& batch,
                                   nlohmann::json& stages) = 0;
  /// For the report.
  virtual nlohmann::json size() const { return nullptr; }
};

/// That of options.visibility and options.common.backend; the box holds the scene at all frames. Options and
/// threads outlive it. Throws InputError where the device cannot be had.
std::unique_ptr<SgTracer> make_sg_tracer(const SgSystemOptions& options, const VoxelBox& box,
                                         const Threads& threads);

}  // namespace coppice::program
