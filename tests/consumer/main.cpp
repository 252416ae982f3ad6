// Uses what the package gives, as a host would: core, and each component that was asked for.
#include <coppice/core/error.hpp>
#include <coppice/scene/scene.hpp>
#include <cstdio>
#include <cstdlib>

#ifdef WITH_EMBREE
#include <coppice/embree/tracer.hpp>
#endif
#ifdef WITH_EXR
#include <coppice/exr/read.hpp>
#include <coppice/exr/write.hpp>
#endif
#ifdef WITH_GLTF
#include <coppice/gltf/load.hpp>
#endif
#ifdef WITH_VULKAN
#include <coppice/vulkan/device.hpp>
#endif

namespace {

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "failed: %s\n", what);
  std::exit(EXIT_FAILURE);
}

coppice::Scene one_triangle() {
  coppice::Scene scene;
  scene.materials.emplace_back();
  scene.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  scene.mesh.normals.assign(3, {0, 0, 1});
  scene.mesh.tangents.resize(3);
  scene.mesh.uvs.resize(3);
  scene.mesh.triangles = {{0, 1, 2}};
  scene.mesh.materials = {0};
  return scene;
}

#ifdef WITH_EMBREE
void use_embree() {
  const coppice::Scene scene = one_triangle();
  const coppice::EmbreeTracer tracer(scene);
  require(tracer.occluded({0.25f, 0.25f, 1}, {0, 0, -1}, 2), "the triangle blocks the ray");
  require(!tracer.occluded({0.75f, 0.75f, 1}, {0, 0, -1}, 2), "the ray passes beside the triangle");
}
#endif

#ifdef WITH_EXR
void use_exr() {
  const coppice::Image image(2, 1, {0.25f, 0.5f, 4});
  coppice::write_exr("consumer.exr", 2, 1, {{"", image}});
  require(coppice::read_image("consumer.exr").pixels == image.pixels, "an image is read as it was written");
}
#endif

#ifdef WITH_GLTF
void use_gltf() {
  try {
    coppice::load_gltf("no such scene.glb");
    require(false, "a missing scene is an error");
  } catch (const coppice::InputError& error) {
    require(error.item().find("no such scene.glb") != std::string::npos, "the error names the file");
  }
}
#endif

#ifdef WITH_VULKAN
void use_vulkan() {
  const auto reason = coppice::VulkanDevice::unavailable();
  std::printf("Vulkan: %s\n", reason ? reason->what() : coppice::VulkanDevice().name().c_str());
}
#endif

}  // namespace

int main() {
  require(one_triangle().mesh.triangles.size() == 1, "core holds a scene");
#ifdef WITH_EMBREE
  use_embree();
#endif
#ifdef WITH_EXR
  use_exr();
#endif
#ifdef WITH_GLTF
  use_gltf();
#endif
#ifdef WITH_VULKAN
  use_vulkan();
#endif
}
