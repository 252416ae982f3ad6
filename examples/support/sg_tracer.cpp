#include <coppice/core/simd.hpp>
//
#include <coppice/core/error.hpp>
#include <coppice/core/stopwatch.hpp>
#include <coppice/sg/ray_cones.hpp>
#include <coppice/voxel/brick_builder.hpp>
#include <coppice/voxel/opacity_mips.hpp>
#include <support/sg_tracer.hpp>
#ifdef COPPICE_HAS_VULKAN
#include <coppice/vulkan/sg_shader.hpp>
#endif

namespace coppice::program {
namespace {

using nlohmann::json;

class RayTracedCones : public SgTracer {
 public:
  RayTracedCones(const SgSystemOptions& options, const Threads& threads)
      : options_(options), threads_(threads) {}

  std::vector<float> trace(const EmbreeTracer& tracer, const ConeBatch& batch, json&) override {
    std::vector<float> visibility(batch.cones.size());
    RayCones(tracer, options_.rays, options_.common.seed)
        .trace(batch.receivers, batch.shapes, visibility, threads_);
    return visibility;
  }

 private:
  const SgSystemOptions& options_;
  const Threads& threads_;
};

/// What all that use a grid share.
class VoxelCones : public SgTracer {
 public:
  VoxelCones(const SgSystemOptions& options, const VoxelBox& box, const Threads& threads)
      : threads_(threads), march_(options.march), voxels_(box, options.voxels) {}

  void build(const Mesh& mesh) override {
    voxels_.build(mesh, threads_);
    changed(mesh);
  }

  void update(const Mesh& mesh, std::size_t resting, json& stages) override {
    Stopwatch watch;
    std::vector<std::uint8_t> moved(mesh.triangles.size(), 1);
    std::fill_n(moved.begin(), resting, std::uint8_t{0});
    voxels_.update(mesh, moved, threads_);
    changed(mesh);
    stages["voxel_update"] = 1e3 * watch.lap();
    stages["voxel_bricks_refreshed"] = voxels_.refreshed();
  }

  std::vector<float> trace(const EmbreeTracer& tracer, const ConeBatch& batch, json&) override {
    std::vector<float> visibility(batch.cones.size());
    ConeTracer(voxels_.grid(), march_).trace(tracer, batch.receivers, batch.shapes, visibility, threads_);
    return visibility;
  }

  json size() const override {
    const BrickGrid& g = voxels_.grid();
    return {{"bricks", g.filled_bricks()}, {"bytes", g.bytes()}, {"dense_bytes", g.dense_bytes()}};
  }

 protected:
  virtual void changed(const Mesh&) {}

  const Threads& threads_;
  ConeTracerOptions march_;
  BrickBuilder voxels_;
};

/// The paper's, dense and made anew for each frame.
class MipCones : public VoxelCones {
 public:
  using VoxelCones::VoxelCones;

  std::vector<float> trace(const EmbreeTracer&, const ConeBatch& batch, json&) override {
    std::vector<float> visibility(batch.cones.size());
    threads_(batch.receivers.size(), 64, [&](std::size_t begin, std::size_t end) {
      int steps = 0;
      for (std::size_t i = begin; i < end; ++i)
        for (std::uint32_t c = batch.begin_of(i); c < batch.receivers[i].cones_end; ++c)
          visibility[c] = mips_->cone_visibility(batch.receivers[i].position, batch.receivers[i].normal,
                                                 batch.shapes[c], steps);
    });
    return visibility;
  }

  json size() const override { return {{"bytes", mips_->bytes()}}; }

 private:
  void changed(const Mesh& mesh) override {
    mips_.emplace(voxels_.grid(), voxels_.triangles(), mesh, threads_);
  }

  std::optional<OpacityMips> mips_;
};

#ifdef COPPICE_HAS_VULKAN
class DeviceCones : public VoxelCones {
 public:
  DeviceCones(const SgSystemOptions& options, const VoxelBox& box, const Threads& threads)
      : VoxelCones(options, box, threads), shader_(device_, march_) {}

  std::vector<float> trace(const EmbreeTracer& tracer, const ConeBatch& batch, json& stages) override {
    std::vector<float> visibility(batch.cones.size());
    shader_.trace(tracer, batch.receivers, batch.shapes, visibility, threads_);
    if (const auto own = shader_.milliseconds()) stages["device_cones"] = *own;
    return visibility;
  }

 private:
  void changed(const Mesh&) override { shader_.set_grid(voxels_.grid()); }

  VulkanDevice device_;
  ConeShader shader_;
};
#endif

}  // namespace

std::unique_ptr<SgTracer> make_sg_tracer(const SgSystemOptions& options, const VoxelBox& box,
                                         const Threads& threads) {
  if (options.visibility == ConeVisibility::rays) return std::make_unique<RayTracedCones>(options, threads);
  if (options.visibility == ConeVisibility::mips) return std::make_unique<MipCones>(options, box, threads);
  if (options.common.backend == "cpu") return std::make_unique<VoxelCones>(options, box, threads);
#ifdef COPPICE_HAS_VULKAN
  return std::make_unique<DeviceCones>(options, box, threads);
#else
  throw InputError("--backend vulkan", "is not part of this build", "build with -DCOPPICE_VULKAN=ON");
#endif
}

}  // namespace coppice::program
