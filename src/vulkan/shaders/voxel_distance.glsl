// Distances to the nearest surface from a grid of bricks: voxel/brick_grid.hpp for kernels. Who includes this
// has defined `parameters`, with the buffers of the grid.

// Four bytes from any offset on.
uint bytes_from(uint offset) {
  uint low = parameters.distances.at[offset / 4u], shift = 8u * (offset % 4u);
  return shift == 0u ? low : low >> shift | parameters.distances.at[offset / 4u + 1u] << (32u - shift);
}

// Where the eight values around a place begin, and how they follow on each other.
struct VoxelCell {
  uint first, row, slice;  // bytes
  uint bits;               // of a value
  vec3 within;             // the place between them
};

float along_x(VoxelCell cell, uint offset) {
  uint both = bytes_from(offset);
  float a = float(bitfieldExtract(both, 0, int(cell.bits)));
  float b = float(bitfieldExtract(both, int(cell.bits), int(cell.bits)));
  return a + cell.within.x * (b - a);
}

float along_y(VoxelCell cell, uint offset) {
  float a = along_x(cell, offset);
  return a + cell.within.y * (along_x(cell, offset + cell.row) - a);
}

float interpolate(VoxelCell cell) {
  float a = along_y(cell, cell.first);
  return a + cell.within.z * (along_y(cell, cell.first + cell.slice) - a);
}

// Inside the grid's box.
float distance_inside(VoxelGrid grid, vec3 place) {
  uvec3 n = grid.bricks;
  uvec3 b = uvec3(voxel_brick(place.x, n.x), voxel_brick(place.y, n.y), voxel_brick(place.z, n.z));
  vec3 within = place - vec3(b * VOXEL_BRICK);
  uint slot = parameters.slots.at[(b.z * n.y + b.y) * n.x + b.x];
  if (slot > 0u) {
    vec3 p = within * VOXEL_PLACES;
    uvec3 i = min(uvec3(p), uvec3(6u));
    uint first = grid.first_brick + (slot - 1u) * VOXEL_BRICK_SIZE + (i.z * 8u + i.y) * 8u + i.x;
    return VOXEL_NEAR_UNIT * interpolate(VoxelCell(first, 8u, 64u, 8u, p - vec3(i)));
  }
  uint row = 2u * (n.x + 1u), slice = row * (n.y + 1u);
  uint first = b.z * slice + b.y * row + 2u * b.x;
  return VOXEL_FAR_UNIT * interpolate(VoxelCell(first, row, slice, 16u, within * 0.125));
}

float nearest_surface(VoxelGrid grid, vec3 place) {
  vec3 inside = clamp(place, vec3(0.0), vec3(grid.bricks * VOXEL_BRICK));
  float d = distance_inside(grid, inside);
  vec3 apart = place - inside;
  return sqrt(d * d + dot(apart, apart));
}
