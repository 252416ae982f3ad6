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
#ifdef WITH_KERNELS
#include <coppice/shared/brdf.h>

#include <coppice/kernels/kernels.hpp>
#endif
#ifdef WITH_PCA
#include <coppice/pca/basis.hpp>
#endif
#ifdef WITH_STORE
#include <coppice/store/store.hpp>
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

#ifdef WITH_KERNELS
void use_kernels() {
  const coppice::vec3 up(0, 0, 1);
  coppice::ShadingPoint point{};
  point.normal = point.to_viewer = up, point.tangent = {1, 0, 0};
  point.brdf = coppice::BRDF_LAMBERT, point.diffuse = coppice::vec3(0.5f), point.weight_0 = 1;
  coppice::FrameLighting frame;
  frame.nodes = {{}, {coppice::vec3(coppice::pi), 0, up, 1}};
  const std::uint64_t seen = 1;
  coppice::vec3 radiance(0);
  coppice::best_kernels<std::uint8_t>().brute_force(coppice::Skip::unseen, {{point}, {{{0, 0, 0}, 0}}, {0}},
                                                    {&seen, 1}, 1, {1, frame}, 0, 1, {&radiance, 1});
  require(length(radiance - coppice::vec3(0.5f)) < 1e-6f, "half of one light comes back");
}
#endif

#ifdef WITH_PCA
void use_pca() {
  coppice::Rows rows(3, 2);
  rows.values = {1, 2, 2, 4, 3, 6};
  require(coppice::pca(rows).rank() == 1, "rows on a line have one principal component");
}
#endif

#ifdef WITH_STORE
void use_store() {
  coppice::StoredVisibility<std::uint8_t> visibility;
  visibility.settings = {{"sigma", "2"}};
  coppice::write_store("consumer.h5", visibility);
  require(coppice::read_store<std::uint8_t>("consumer.h5").settings == visibility.settings,
          "a store is read as it was written");
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
#ifdef WITH_KERNELS
  use_kernels();
#endif
#ifdef WITH_PCA
  use_pca();
#endif
#ifdef WITH_STORE
  use_store();
#endif
#ifdef WITH_VULKAN
  use_vulkan();
#endif
}
