// The backend that shades points: this processor or a Vulkan device.
#pragma once

#include <coppice/embree/threads.hpp>
#include <coppice/relight/cut_relighting.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace coppice::program {

class Shader {
 public:
  virtual ~Shader() = default;
  /// Radiance by point; `clusters` receives each point's number of clusters where the backend knows it.
  virtual std::vector<vec3> shade(const FrameLighting& lighting, const Threads& threads,
                                  std::span<std::uint32_t> clusters) = 0;
};

/// The same for lights in the scene.
class LocalShader {
 public:
  virtual ~LocalShader() = default;
  virtual std::vector<vec3> shade(const Threads& threads, std::span<std::uint32_t> clusters) = 0;
};

/// Throws InputError where that backend cannot be had: asked before the work begins. Costs as much as to open
/// it.
void require_backend(const std::string& backend);

/// "cpu" or "vulkan". Throws InputError where that cannot be had.
std::unique_ptr<Shader> make_shader(const std::string& backend, const CutRelighting<>& relighting);

/// The view and the relighting must outlive it.
std::unique_ptr<LocalShader> make_local_shader(const std::string& backend, const PreparedView& view,
                                               const LocalRelighting& relighting);

}  // namespace coppice::program
