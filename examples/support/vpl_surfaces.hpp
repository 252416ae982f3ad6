// How the programs of VPLs read materials.
#pragma once

#include <coppice/gather/glossy_points.hpp>
//
#include <support/vpl_options.hpp>

namespace coppice::program {

/// The materials of the file, or what --exponents makes of them: a quarter of the light at least is reflected
/// in a lobe, whose exponent is drawn for each material.
struct ProgramSurfaces {
  const Scene& scene;
  Shading shading;
  std::optional<ExponentRange> exponents;

  PhongSurface operator()(const Hit& hit, const vec3& towards) const {
    if (!exponents) return SceneSurfaces{scene, shading}(hit, towards);
    const ShadingPoint p = shading_point(scene, hit, towards, Shading::phong);
    const float u = Random(scene.mesh.materials[hit.triangle]).uniform();
    return {0.75f * p.diffuse, glm::max(p.specular, vec3(0.25f)),
            exponents->least * std::pow(exponents->most / exponents->least, u)};
  }
};

/// All primary lights: those of the scene, and the sky where an environment is named.
std::vector<LocalLight> primary_lights(const VplSystemOptions& options, const Scene& scene,
                                       const Environment& environment);

}  // namespace coppice::program
