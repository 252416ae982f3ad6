#include <algorithm>
#include <coppice/core/config.hpp>
#include <coppice/core/error.hpp>
#include <coppice/embree/tracer.hpp>
#include <cstring>
#include <limits>
#include <type_traits>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace coppice {
namespace {

// All that differs between Embree 3 and 4. The rays stay incoherent: the COHERENT flag slows shadow packets
// down.
#if RTC_VERSION_MAJOR >= 4
void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray, nullptr); }
void occlude(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, nullptr); }
void occlude(RTCScene scene, const int* valid, RTCRay16& rays) {
  rtcOccluded16(valid, scene, &rays, nullptr);
}
#else
RTCIntersectContext make_context() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return context;
}
void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext context = make_context();
  rtcIntersect1(scene, &context, &ray);
}
void occlude(RTCScene scene, RTCRay& ray) {
  RTCIntersectContext context = make_context();
  rtcOccluded1(scene, &context, &ray);
}
void occlude(RTCScene scene, const int* valid, RTCRay16& rays) {
  RTCIntersectContext context = make_context();
  rtcOccluded16(valid, scene, &context, &rays);
}
#endif

template <class Handle, void (*release)(Handle)>
struct Releaser {
  void operator()(Handle handle) const { release(handle); }
};
template <class Handle, void (*release)(Handle)>
using Owner = std::unique_ptr<std::remove_pointer_t<Handle>, Releaser<Handle, release>>;
using DeviceOwner = Owner<RTCDevice, rtcReleaseDevice>;
using SceneOwner = Owner<RTCScene, rtcReleaseScene>;
using GeometryOwner = Owner<RTCGeometry, rtcReleaseGeometry>;
using BufferOwner = Owner<RTCBuffer, rtcReleaseBuffer>;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr unsigned solid_geometry = 0, masked_geometry = 1;

/// Throws where an earlier call into Embree failed.
void check(RTCDevice device) {
  switch (const RTCError error = rtcGetDeviceError(device)) {
    case RTC_ERROR_NONE:
      return;
    case RTC_ERROR_OUT_OF_MEMORY:
      throw InputError("Embree", "out of memory", "use a smaller scene or a machine with more memory");
    case RTC_ERROR_UNSUPPORTED_CPU:
      throw InputError("Embree", "this processor lacks the instructions it was built for",
                       "install an Embree built for this processor");
    default:
      throw InputError("Embree", "failed with error code " + std::to_string(int(error)),
                       "check that the installed Embree is the version that Coppice was built with");
  }
}

DeviceOwner make_device() {
  DeviceOwner device(rtcNewDevice(nullptr));
  if (!device) check(nullptr);
  if (!device) throw InputError("Embree", "cannot be started", "check its installation");
  return device;
}

[[maybe_unused]] bool well_formed(const Scene& scene) {
  const Mesh& mesh = scene.mesh;
  return mesh.materials.size() == mesh.triangles.size() &&
         std::ranges::all_of(mesh.triangles,
                             [&](const uvec3& t) {
                               return std::max({t.x, t.y, t.z}) < mesh.positions.size();
                             }) &&
         std::ranges::all_of(mesh.materials, [&](std::uint32_t m) { return m < scene.materials.size(); });
}

/// Indices of the triangles whose material has an alpha mask, or of all others, in ascending order.
std::vector<std::uint32_t> triangles_with_mask(const Scene& scene, bool masked) {
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i)
    if (scene.materials[scene.mesh.materials[i]].alpha_mask == masked) chosen.push_back(std::uint32_t(i));
  return chosen;
}

/// The triangles that may have holes, as Embree's filter function sees them.
struct MaskedTriangles {
  const Scene* scene;
  std::vector<std::uint32_t> triangles;  ///< by Embree's primitive id

  bool hole(unsigned primitive, float u, float v) const;
  static void reject_holes(const RTCFilterFunctionNArguments* arguments);
};

bool MaskedTriangles::hole(unsigned primitive, float u, float v) const {
  const Mesh& mesh = scene->mesh;
  const Material& material = scene->materials[mesh.materials[triangles[primitive]]];
  if (material.base_color_texture < 0) return material.alpha < material.alpha_cutoff;
  const uvec3 corners = mesh.triangles[triangles[primitive]];
  const vec2 uv = (1 - u - v) * mesh.uvs[corners.x] + u * mesh.uvs[corners.y] + v * mesh.uvs[corners.z];
  const Texture& texture = scene->textures[std::size_t(material.base_color_texture)];
  return material.alpha * sample(texture, uv).a < material.alpha_cutoff;
}

void MaskedTriangles::reject_holes(const RTCFilterFunctionNArguments* arguments) {
  const auto& masked = *static_cast<const MaskedTriangles*>(arguments->geometryUserPtr);
  const unsigned count = arguments->N;
  for (unsigned i = 0; i < count; ++i) {
    if (arguments->valid[i] == 0) continue;
    const unsigned primitive = RTCHitN_primID(arguments->hit, count, i);
    if (masked.hole(primitive, RTCHitN_u(arguments->hit, count, i), RTCHitN_v(arguments->hit, count, i)))
      arguments->valid[i] = 0;
  }
}

/// The positions in Embree's own memory: it reads 16 bytes beyond the last one.
BufferOwner copy_positions(RTCDevice device, const std::vector<vec3>& positions) {
  const std::size_t bytes = positions.size() * sizeof(vec3);
  BufferOwner buffer(rtcNewBuffer(device, bytes + 16));
  check(device);
  std::memcpy(rtcGetBufferData(buffer.get()), positions.data(), bytes);
  return buffer;
}

GeometryOwner make_geometry(RTCDevice device, RTCBuffer positions, const Mesh& mesh,
                            const std::vector<std::uint32_t>& triangles) {
  GeometryOwner geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetGeometryBuildQuality(geometry.get(), RTC_BUILD_QUALITY_HIGH);
  rtcSetGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0,
                       sizeof(vec3), mesh.positions.size());
  void* indices = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          sizeof(uvec3), triangles.size());
  check(device);
  std::ranges::transform(triangles, static_cast<uvec3*>(indices),
                         [&](std::uint32_t triangle) { return mesh.triangles[triangle]; });
  return geometry;
}

SceneOwner make_tree(RTCDevice device, RTCSceneFlags flags) {
  SceneOwner tree(rtcNewScene(device));
  check(device);
  rtcSetSceneFlags(tree.get(), flags);
  rtcSetSceneBuildQuality(tree.get(), RTC_BUILD_QUALITY_HIGH);
  return tree;
}

RTCRay make_ray(const vec3& origin, const vec3& direction, float t_max) {
  RTCRay ray{};
  ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z;
  ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
  ray.tfar = t_max;
  ray.mask = ~0u;
  return ray;
}

RTCRay16 make_rays(const ShadowPacket& packet) {
  RTCRay16 rays;
  const auto copy = [](const float(&from)[16], float(&to)[16]) { std::copy_n(from, 16, to); };
  copy(packet.origin_x, rays.org_x), copy(packet.origin_y, rays.org_y), copy(packet.origin_z, rays.org_z);
  copy(packet.direction_x, rays.dir_x), copy(packet.direction_y, rays.dir_y);
  copy(packet.direction_z, rays.dir_z), copy(packet.t_max, rays.tfar);
  std::fill_n(rays.tnear, 16, 0.0f), std::fill_n(rays.time, 16, 0.0f);
  std::fill_n(rays.mask, 16, ~0u), std::fill_n(rays.id, 16, 0u), std::fill_n(rays.flags, 16, 0u);
  return rays;
}

}  // namespace

struct EmbreeTracer::State {
  explicit State(const Scene& scene);
  void add_triangles(const Mesh& mesh);
  void attach(RTCGeometry geometry, unsigned id);

  std::vector<std::uint32_t> solid;  ///< by Embree's primitive id
  MaskedTriangles masked;
  DeviceOwner device;
  SceneOwner camera_tree;  ///< robust: no ray slips through along an edge, which an image would show
  SceneOwner
      shadow_tree;  ///< not so: 1.6 to 2 times the rays a second, and a light in 10⁵ matters to no receiver
};

EmbreeTracer::State::State(const Scene& scene)
    : solid(triangles_with_mask(scene, false)),
      masked{&scene, triangles_with_mask(scene, true)},
      device(make_device()),
      camera_tree(make_tree(device.get(), RTC_SCENE_FLAG_ROBUST)),
      shadow_tree(make_tree(device.get(), RTC_SCENE_FLAG_NONE)) {
  if (!scene.mesh.triangles.empty()) add_triangles(scene.mesh);
  rtcCommitScene(camera_tree.get());
  rtcCommitScene(shadow_tree.get());
  check(device.get());
}

void EmbreeTracer::State::attach(RTCGeometry geometry, unsigned id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(camera_tree.get(), geometry, id);
  rtcAttachGeometryByID(shadow_tree.get(), geometry, id);
}

void EmbreeTracer::State::add_triangles(const Mesh& mesh) {
  const BufferOwner positions = copy_positions(device.get(), mesh.positions);
  if (!solid.empty()) attach(make_geometry(device.get(), positions.get(), mesh, solid).get(), solid_geometry);
  if (masked.triangles.empty()) return;
  const GeometryOwner geometry = make_geometry(device.get(), positions.get(), mesh, masked.triangles);
  rtcSetGeometryUserData(geometry.get(), &masked);
  rtcSetGeometryIntersectFilterFunction(geometry.get(), MaskedTriangles::reject_holes);
  rtcSetGeometryOccludedFilterFunction(geometry.get(), MaskedTriangles::reject_holes);
  attach(geometry.get(), masked_geometry);
}

EmbreeTracer::EmbreeTracer(const Scene& scene) {
  COPPICE_ASSERT(well_formed(scene));
  state_ = std::make_unique<State>(scene);
}
EmbreeTracer::~EmbreeTracer() = default;
EmbreeTracer::EmbreeTracer(EmbreeTracer&&) noexcept = default;
EmbreeTracer& EmbreeTracer::operator=(EmbreeTracer&&) noexcept = default;

std::optional<Hit> EmbreeTracer::closest(const vec3& origin, const vec3& direction) const {
  COPPICE_ASSERT(is_finite(origin) && is_finite(direction));
  RTCRayHit ray{make_ray(origin, direction, infinity), {}};
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  intersect(state_->camera_tree.get(), ray);
  const RTCHit& hit = ray.hit;
  if (hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const auto& triangles = hit.geomID == solid_geometry ? state_->solid : state_->masked.triangles;
  const bool front = dot(direction, vec3(hit.Ng_x, hit.Ng_y, hit.Ng_z)) < 0;
  return Hit{triangles[hit.primID], hit.u, hit.v, ray.ray.tfar, front};
}

// Embree reports a blocked ray by tfar = -infinity.

bool EmbreeTracer::occluded(const vec3& origin, const vec3& direction, float t_max) const {
  COPPICE_ASSERT(is_finite(origin) && is_finite(direction));
  RTCRay ray = make_ray(origin, direction, t_max);
  occlude(state_->shadow_tree.get(), ray);
  return ray.tfar == -infinity;
}

std::uint32_t EmbreeTracer::occluded(const ShadowPacket& packet, std::uint32_t lanes) const {
  alignas(64) int valid[16];
  for (std::uint32_t i = 0; i < 16; ++i) valid[i] = lanes >> i & 1 ? -1 : 0;
  RTCRay16 rays = make_rays(packet);
  occlude(state_->shadow_tree.get(), valid, rays);
  std::uint32_t blocked = 0;
  for (std::uint32_t i = 0; i < 16; ++i) blocked |= std::uint32_t(rays.tfar[i] == -infinity) << i;
  return blocked & lanes;
}

}  // namespace coppice
