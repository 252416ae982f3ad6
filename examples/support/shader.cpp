#include <coppice/core/error.hpp>
#include <support/shader.hpp>
#ifdef COPPICE_HAS_VULKAN
#include <coppice/vulkan/cut_shader.hpp>
#include <coppice/vulkan/local_cut_shader.hpp>
#endif

namespace coppice::program {

namespace {

class CpuShader : public Shader {
 public:
  explicit CpuShader(const CutRelighting<>& relighting) : relighting_(relighting) {}
  std::vector<vec3> shade(const FrameLighting& lighting, const Threads& threads,
                          std::span<std::uint32_t> clusters) override {
    return relighting_.shade(lighting, threads, 0, clusters);
  }

 private:
  const CutRelighting<>& relighting_;
};

class LocalCpuShader : public LocalShader {
 public:
  explicit LocalCpuShader(const LocalRelighting& relighting) : relighting_(relighting) {}
  std::vector<vec3> shade(const Threads& threads, std::span<std::uint32_t> clusters) override {
    return relighting_.shade(threads, clusters);
  }

 private:
  const LocalRelighting& relighting_;
};

#ifdef COPPICE_HAS_VULKAN
class LocalVulkanShader : public LocalShader {
 public:
  LocalVulkanShader(const PreparedView& view, const LocalRelighting& relighting)
      : relighting_(relighting), shader_(device_, input(view, relighting)) {}
  std::vector<vec3> shade(const Threads&, std::span<std::uint32_t> clusters) override {
    const auto& frame = relighting_.frame();
    return shader_.shade(frame.nodes, frame.mask, relighting_.options().lobes, clusters).radiance;
  }

 private:
  static LocalCutShadeInput input(const PreparedView& view, const LocalRelighting& relighting) {
    const auto& cuts = relighting.cuts().cuts;
    LocalCutShadeInput input;
    input.leaf_count = cuts.leaf_count();
    input.granule_log2 = cuts.granule_log2();
    input.visibility_masks = cuts.masks();
    input.first_value = cuts.first_value();
    input.values = cuts.values();
    input.scales = relighting.cuts().scales;
    input.faces = view.buffer.faces;
    input.points = view.buffer.points;
    input.positions = view.buffer.positions;
    return input;
  }

  const LocalRelighting& relighting_;
  VulkanDevice device_;
  LocalCutShader shader_;
};

class VulkanShader : public Shader {
 public:
  explicit VulkanShader(const CutRelighting<>& relighting)
      : lobes_(relighting.options().lobes), shader_(device_, input(relighting)) {}
  std::vector<vec3> shade(const FrameLighting& lighting, const Threads&,
                          std::span<std::uint32_t> clusters) override {
    return shader_.shade(lighting.nodes, lighting.mask, lobes_, clusters).radiance;
  }

 private:
  static CutShadeInput input(const CutRelighting<>& relighting) {
    const auto& cuts = relighting.cuts();
    CutShadeInput input;
    input.leaf_count = cuts.leaf_count();
    input.granule_log2 = cuts.granule_log2();
    input.visibility_masks = cuts.masks();
    input.first_value = cuts.first_value();
    input.values = cuts.values();
    input.horizons = cuts.horizons();
    input.faces = relighting.buffer().faces;
    input.points = relighting.buffer().points;
    return input;
  }

  LobeOptions lobes_;
  VulkanDevice device_;
  CutShader shader_;
};
#endif

}  // namespace

void require_backend(const std::string& backend) {
  if (backend == "cpu") return;
#ifdef COPPICE_HAS_VULKAN
  if (const auto error = VulkanDevice::unavailable())
    throw InputError("--backend " + backend, error->what(), "use --backend cpu");
#else
  throw InputError("--backend " + backend, "is not part of this build", "build with -DCOPPICE_VULKAN=ON");
#endif
}

std::unique_ptr<Shader> make_shader(const std::string& backend, const CutRelighting<>& relighting) {
  if (backend == "cpu") return std::make_unique<CpuShader>(relighting);
#ifdef COPPICE_HAS_VULKAN
  return std::make_unique<VulkanShader>(relighting);
#else
  require_backend(backend);
  return nullptr;
#endif
}

std::unique_ptr<LocalShader> make_local_shader(const std::string& backend, const PreparedView& view,
                                               const LocalRelighting& relighting) {
#ifdef COPPICE_HAS_VULKAN
  if (backend != "cpu" && !relighting.lights().empty())
    return std::make_unique<LocalVulkanShader>(view, relighting);
#endif
  if (backend != "cpu") require_backend(backend);
  (void)view;
  return std::make_unique<LocalCpuShader>(relighting);
}

}  // namespace coppice::program
