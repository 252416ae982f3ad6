// One invocation a cone: how much of it the distances of a grid leave visible (voxel/cone_tracer.hpp).
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#define COPPICE_GLSL
#include <coppice/shared/sg_kernels.h>

layout(local_size_x = KERNEL_GROUP_SIZE) in;
layout(push_constant, scalar) uniform Push { ConesParameters parameters; };

#include "voxel_distance.glsl"

// The first receiver whose cones end behind this one.
uint receiver_of(uint cone) {
  uint low = 0u, high = parameters.receiver_count - 1u;
  while (low < high) {
    uint middle = (low + high) / 2u;
    if (parameters.receivers.at[middle].cones_end > cone)
      high = middle;
    else
      low = middle + 1u;
  }
  return low;
}

// make_frame() of core/math.hpp.
mat3 frame_of(vec3 n) {
  float side = floatBitsToInt(n.z) < 0 ? -1.0 : 1.0;
  float a = -1.0 / (side + n.z), b = n.x * n.y * a;
  vec3 tangent = vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x);
  return mat3(tangent, vec3(b, side + n.y * n.y * a, -n.y), n);
}

// Nothing of the grid is ahead of a ray beyond this distance.
float last_surface(vec3 size, vec3 from, vec3 direction) {
  vec3 middle = 0.5 * size;
  float all = dot(middle - from, direction) + dot(middle, abs(direction));
  vec3 inverse = 1.0 / mix(vec3(1e-12), direction, greaterThan(abs(direction), vec3(1e-12)));
  vec3 a = -from * inverse, b = (size - from) * inverse;
  vec3 low = min(a, b), high = max(a, b);
  float exit = min(min(all, high.x), min(high.y, high.z)), entry = max(max(0.0, low.x), max(low.y, low.z));
  return entry < exit ? exit : all;
}

// A ray's march: from the place and the normal of its receiver, in voxels.
float march(ConeSettings settings, vec3 from, vec3 normal, vec3 direction, float width) {
  VoxelTrace trace = settings.trace;
  float slope = max(dot(normal, direction), 0.0), reach = trace.softness * width;
  vec3 start = from + trace.lift * normal;
  float end = last_surface(vec3(settings.grid.bricks * VOXEL_BRICK), start, direction);
  float t = trace.start, open = 1.0;
  for (uint step = 0u; step < trace.steps && t < end && open > 0.0; ++step) {
    float d = nearest_surface(settings.grid, start + t * direction), rise = trace.lift + t * slope;
    open = min(open, voxel_opening(d, t, rise, reach, trace.skin, trace.slack));
    t += voxel_stride(d, t, reach, trace.growth);
  }
  return open;
}

// Ray i before it is turned up to the horizon: around the cone's axis by the cosine and sine of `turn`.
vec3 ray_direction(SgShape cone, mat3 frame, uint i, uint count, vec2 turn) {
  float u = min((float(i) + 0.5) / float(count), 0.999);
  float drop = count == 1u ? 0.0 : voxel_ray_drop(u, max(cone.sharpness, 1e-4));
  float radius = sqrt(max(drop * (2.0 - drop), 0.0));
  return (1.0 - drop) * cone.axis + radius * (turn.x * frame[0] + turn.y * frame[1]);
}

vec3 turned_up(vec3 d, vec3 normal) {
  float size2 = dot(d, d);
  return size2 > 1e-12 ? d / sqrt(size2) : normal;
}

// Of what is above the shading horizon, the part that is above the surface's too and that nothing closes.
float visibility_of(ConeSettings settings, ConeReceiver receiver, SgShape cone, uint closed) {
  uint count = settings.trace.rays;
  vec3 from = (receiver.position - settings.grid.low) * settings.grid.voxels_per_unit;
  float width = voxel_ray_width(cone.sharpness, count), least = voxel_ray_least_rise(width);
  mat3 frame = frame_of(cone.axis);
  vec2 turn = vec2(1.0, 0.0);
  float seen = 0.0, all = 0.0;
  for (uint i = 0u; i < count; ++i) {
    vec3 d = ray_direction(cone, frame, i, count, turn);
    turn = vec2(turn.x * SG_TURN_COSINE - turn.y * SG_TURN_SINE,
                turn.x * SG_TURN_SINE + turn.y * SG_TURN_COSINE);
    float rise = dot(d, receiver.normal), lit = voxel_ray_share(dot(d, receiver.shading_normal), width);
    float share = min(lit, voxel_ray_share(rise, width));
    all += lit;
    if (share <= 0.0 || (i < SG_CONTACT_RAYS && (closed >> i & 1u) != 0u)) continue;
    d = turned_up(d + max(least - rise, 0.0) * receiver.normal, receiver.normal);
    seen += share * march(settings, from, receiver.normal, d, width);
  }
  return all > 0.0 ? min(seen / all, 1.0) : 0.0;
}

void main() {
  uint index = parameters.range.begin + gl_GlobalInvocationID.x;
  if (index >= parameters.range.end) return;
  ConeReceiver receiver = parameters.receivers.at[receiver_of(parameters.before + index)];
  uint closed = 0u;
  if (parameters.has_closed != 0u)
    closed = parameters.closed.at[index / 4u] >> (8u * (index % 4u)) & 255u;
  parameters.visibility.at[index] =
      visibility_of(parameters.settings.at[0], receiver, parameters.cones.at[index], closed);
}
