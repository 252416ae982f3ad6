// Repairs and completes the surface of one primitive in the units of the world.
#pragma once

#include <coppice/scene/mesh.hpp>
#include <cstddef>

namespace coppice::gltf {

/// Edge cross products shorter than this (twice an area, in square units of the world) are zero to float
/// code, which squares them.
inline constexpr double least_cross = 1e-18;

/// Removes triangles without area, and the materials beside them; returns how many.
std::size_t drop_flat_triangles(Mesh& mesh);

/// Gives each triangle vertices of its own and its geometric normal.
void make_flat_normals(Mesh& mesh);

/// Normalises the normals; those without a direction become the area-weighted mean of the geometric normals
/// around them. Returns how many. Precondition: every vertex is a corner of a triangle with area.
std::size_t normalize_normals(Mesh& mesh);

/// Makes given tangents orthonormal to the normals; xyz becomes zero where that is impossible.
void orthonormalize_tangents(Mesh& mesh);

/// Tangents from the derivatives of uv: the mean over the triangles around a vertex, weighted by the angle
/// there, after Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008). As v points down in glTF and a
/// normal texture's y points up, the bitangent w·(n × t) points towards -v. xyz is zero where uv is
/// degenerate.
void make_tangents(Mesh& mesh);

/// Removes vertices that no triangle uses; the others keep their order.
void drop_unused_vertices(Mesh& mesh);

}  // namespace coppice::gltf
