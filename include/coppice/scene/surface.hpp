// From a hit to what is shaded there: mapped normal, material parameters, emission.
#pragma once

#include <coppice/brdf/with_brdf.hpp>
#include <coppice/scene/hit.hpp>
#include <coppice/scene/scene.hpp>

namespace coppice {

/// Vertex attributes at a hit. The normal is that of the mesh, on whatever side the viewer is.
struct Surface {
  vec3 normal;
  vec3 tangent;  ///< zero where the mesh has none
  float bitangent_sign;
  vec2 uv;
};

/// True where a ray meets the side on which the vertex normals are, whatever the winding says.
inline bool seen_from_front(const Mesh& mesh, const Hit& hit) {
  const uvec3 t = mesh.triangles[hit.triangle];
  const vec3 geometric =
      cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
  return (dot(geometric, mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z]) >= 0) == hit.front;
}

inline vec3 position_at(const Mesh& mesh, const Hit& hit) {
  const uvec3 t = mesh.triangles[hit.triangle];
  return (1 - hit.u - hit.v) * mesh.positions[t.x] + hit.u * mesh.positions[t.y] +
         hit.v * mesh.positions[t.z];
}

inline Surface surface_at(const Mesh& mesh, const Hit& hit) {
  const uvec3 t = mesh.triangles[hit.triangle];
  const float w = 1 - hit.u - hit.v;
  const auto mix = [&](const auto& values) {
    return w * values[t.x] + hit.u * values[t.y] + hit.v * values[t.z];
  };
  const vec4 tangent = mix(mesh.tangents);
  const vec3 geometric =
      cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
  return {normalize_or(mix(mesh.normals), normalize_or(geometric, vec3(0, 1, 0))), vec3(tangent),
          tangent.w < 0 ? -1.0f : 1.0f, mix(mesh.uvs)};
}

/// The normal that the normal map bends, on the mesh normal's side.
inline vec3 mapped_normal(const Scene& scene, const Material& material, const Surface& s) {
  if (material.normal_texture < 0) return s.normal;
  const vec3 t = tangent_across(s.tangent, s.normal);
  if (t == vec3(0)) return s.normal;
  const vec3 texel = 2.0f * vec3(sample(scene.textures[std::size_t(material.normal_texture)], s.uv)) - 1.0f;
  const vec3 n = vec3(material.normal_scale * texel.x, material.normal_scale * texel.y, texel.z);
  return normalize_or(n.x * t + n.y * s.bitangent_sign * cross(s.normal, t) + n.z * s.normal, s.normal);
}

inline vec3 textured(const Scene& scene, const vec3& factor, int texture, vec2 uv) {
  return texture < 0 ? factor : factor * vec3(sample(scene.textures[std::size_t(texture)], uv));
}

/// How materials are read: as glTF means them, as pure Lambert of their base colour, or as one of the classic
/// lobes with the same colours and a width from the same roughness.
enum class Shading { metallic_roughness, lambert, phong, blinn_phong, ward };

/// Fills the BRDF of the point from metallic-roughness parameters. The classic lobes have specular colour f0
/// (4% for dielectrics, the base colour for metals) and no Fresnel. With α = roughness²: Blinn-Phong's
/// exponent is 2/α² - 2 (Walter et al. 2007), Phong's a quarter of it, and Ward is α wide along the tangent
/// and α/2 across it.
inline void set_material(ShadingPoint& point, Shading shading, const vec3& base, float metallic,
                         float roughness) {
  const vec3 f0 = glm::mix(vec3(0.04f), base, metallic), diffuse = base * (1 - metallic) * (vec3(1) - f0);
  const float alpha = valid_alpha(roughness * roughness), exponent = 2 / (alpha * alpha) - 2;
  switch (shading) {
    case Shading::metallic_roughness:
      return set_metallic_roughness(point, base, metallic, roughness);
    case Shading::lambert:
      return set_lambert(point, base);
    case Shading::phong:
      return set_phong(point, diffuse, f0, exponent / 4);
    case Shading::blinn_phong:
      return set_blinn_phong(point, diffuse, f0, exponent);
    case Shading::ward:
      return set_ward(point, diffuse, f0, alpha, alpha / 2);
  }
}

/// Fills the point but for its face and weights. The shading normal is turned to the viewer by its own sign,
/// as path tracers do: where a silhouette's smooth normal looks away the point is dark, and so it is in their
/// images (turning it by the side that the ray meets raised relRMSE against pbrt from 1.1% to 2.0%). The
/// tangent frame follows the mesh's tangents where it has them. Cost: at most three bilinear texture samples.
inline ShadingPoint shading_point(const Scene& scene, const Hit& hit, const vec3& to_viewer,
                                  Shading shading) {
  const Material& material = scene.materials[scene.mesh.materials[hit.triangle]];
  const Surface s = surface_at(scene.mesh, hit);
  ShadingPoint p{};
  p.to_viewer = to_viewer;
  p.normal = mapped_normal(scene, material, s) * (dot(s.normal, to_viewer) < 0 ? -1.0f : 1.0f);
  p.tangent = tangent_across(s.tangent, p.normal);
  vec3 bitangent;
  if (p.tangent == vec3(0)) make_frame(p.normal, p.tangent, bitangent);
  const vec3 base = textured(scene, material.base_color, material.base_color_texture, s.uv);
  const vec3 packed =
      textured(scene, {1, material.roughness, material.metallic}, material.metallic_roughness_texture, s.uv);
  set_material(p, shading, base, packed.z, packed.y);
  return p;
}

/// Radiance that the surface itself emits towards a viewer who sees its front (counter-clockwise) side.
inline vec3 emission_at(const Scene& scene, const Hit& hit) {
  const Material& material = scene.materials[scene.mesh.materials[hit.triangle]];
  if (!hit.front && !material.double_sided) return vec3(0);
  if (material.emission == vec3(0)) return vec3(0);
  return textured(scene, material.emission, material.emission_texture, surface_at(scene.mesh, hit).uv);
}

}  // namespace coppice
