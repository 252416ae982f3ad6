// Particles that fly through a scene and find the surfaces and the free space that can be reached from
// inside.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/light/bounce.hpp>
#include <coppice/scene/hit.hpp>
#include <coppice/transfer/near_samples.hpp>
#include <coppice/transfer/reached_area.hpp>

namespace coppice {

/// What happens to a particle that leaves the scene.
enum class Escape {
  automatic,    ///< start_again where at least half of a thousand particles get to their candidates, else sky
  start_again,  ///< it is lost; the next begins at its starting point
  sky           ///< a ball round the scene sends it back like a white wall: for scenes without a roof
};

struct ParticleOptions {
  std::size_t count = 270000;  ///< candidates wanted; six for a sample
  std::uint64_t seed = 0;
  Escape escape = Escape::automatic;
  std::uint32_t reflections = 5;  ///< before the first candidate (PCA section 4.1)
  std::uint32_t most_hits = 256;  ///< of a particle; many, so that the rooms behind doors get their share
  Shading shading = Shading::metallic_roughness;
};

/// A straight way that nothing blocks.
struct Flight {
  vec3 from{0}, to{0};
  bool from_sky = false;  ///< it begins on the ball round the scene, else on a surface
};

/// What particles found.
struct ParticleField {
  std::vector<SurfaceSample> candidates;  ///< colours: albedos; areas: all the same, Σ the area reached
  std::vector<Flight> flights;            ///< a candidate: the way that ended there
  std::vector<std::uint32_t> particle;    ///< a candidate: whose it is; ascending
  std::size_t traced = 0;                 ///< particles
  std::size_t escaped = 0;                ///< times that one left the scene
  std::size_t stray = 0;                  ///< hits that were dropped, in solids or behind walls
  bool sky = false;                       ///< whether they came back
  double area = 0;                        ///< m² of the surfaces reached; docs/transfer.md
};

namespace detail {

/// Lambert's law round the unit vector n.
inline vec3 cosine_direction(Random& random, const vec3& n) {
  vec3 tangent, bitangent;
  make_frame(n, tangent, bitangent);
  const float r2 = random.uniform(), phi = 2 * pi * random.uniform(), r = std::sqrt(r2);
  return normalize(r * std::cos(phi) * tangent + r * std::sin(phi) * bitangent + std::sqrt(1 - r2) * n);
}

struct Ball {
  vec3 centre{0};
  float radius = 0;
};

/// Round the mesh's box, a little larger.
inline Ball ball_around(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  vec3 low = mesh.positions[0], high = low;
  for (const vec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
  return {0.5f * (low + high), 0.51f * length(high - low)};
}

/// A particle's candidates and their flights.
struct ParticlePath {
  std::vector<SurfaceSample> hits;
  std::vector<Flight> flights;
  std::uint32_t escaped = 0;
  bool arrived = false;  ///< it lived through its first reflections
};

inline SurfaceSample sample_at(const Scene& scene, const Hit& hit) {
  SurfaceSample s{.side = {hit.triangle, hit.front}, .u = hit.u, .v = hit.v};
  s.position = position_at(scene.mesh, hit);
  const vec3 normal = normalize_or(vec3(area_normal(scene.mesh, hit.triangle)), vec3(0));
  s.normal = hit.front ? normal : -normal;
  return s;
}

/// Follows one particle. With a ball it returns from there, wherever it left.
template <RayTracer T>
ParticlePath fly(const Scene& scene, const T& tracer, const vec3& start, const Ball* sky, Random random,
                 const ParticleOptions& options) {
  ParticlePath path;
  Flight flight{start, start, false};
  vec3 direction = random.direction();
  for (std::uint32_t k = 0; k < options.most_hits; ++k) {
    path.arrived = k >= options.reflections;
    const std::optional<Hit> hit = tracer.closest(flight.from, direction);
    if (!hit) {
      ++path.escaped;
      if (!sky) break;
      const vec3 inwards = random.direction();
      flight = {sky->centre - sky->radius * inwards, vec3(0), true};
      direction = cosine_direction(random, inwards);
      continue;
    }
    const SurfaceSample s = sample_at(scene, *hit);
    if (s.normal == vec3(0)) break;
    flight.to = ray_origin(s);
    if (path.arrived) path.hits.push_back(s), path.flights.push_back(flight);
    flight = {flight.to, vec3(0), false};
    direction = cosine_direction(random, s.normal);
  }
  return path;
}

/// Particles [first, first + paths.size()), each with random numbers and a starting point of its own.
template <RayTracer T, Executor E>
void fly_all(const Scene& scene, const T& tracer, std::span<const vec3> starts, const Ball* sky,
             std::size_t first, std::span<ParticlePath> paths, const ParticleOptions& options,
             const E& executor) {
  executor(paths.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t particle = first + i;
      Random random(Random(options.seed + particle).bits());
      paths[i] = fly(scene, tracer, starts[particle % starts.size()], sky, random, options);
    }
  });
}

/// Whether half of the first particles live through their first reflections.
template <RayTracer T, Executor E>
bool is_closed(const Scene& scene, const T& tracer, std::span<const vec3> starts,
               const ParticleOptions& options, const E& executor) {
  ParticleOptions few = options;
  few.most_hits = options.reflections + 1;
  std::vector<ParticlePath> paths(1024);
  fly_all(scene, tracer, starts, nullptr, 0, paths, few, executor);
  return 2 * std::ranges::count_if(paths, [](const ParticlePath& p) { return p.arrived; }) >=
         std::ptrdiff_t(paths.size());
}

/// Adds a particle's candidates, as many as are still wanted.
inline void append(ParticleField& field, const ParticlePath& path, std::size_t wanted) {
  const std::size_t taken = std::min(path.hits.size(), wanted - field.candidates.size());
  field.candidates.insert(field.candidates.end(), path.hits.begin(),
                          path.hits.begin() + std::ptrdiff_t(taken));
  field.flights.insert(field.flights.end(), path.flights.begin(),
                       path.flights.begin() + std::ptrdiff_t(taken));
  field.particle.insert(field.particle.end(), taken, std::uint32_t(field.traced++));
  field.escaped += path.escaped;
}

/// Keeps the candidates that have no mark.
inline void erase_marked(ParticleField& field, std::span<const std::uint8_t> marked) {
  std::size_t left = 0;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i]) continue;
    field.candidates[left] = field.candidates[i];
    field.flights[left] = field.flights[i];
    field.particle[left++] = field.particle[i];
  }
  field.candidates.resize(left), field.flights.resize(left), field.particle.resize(left);
}

/// Marks what a particle met from its first back of a single-sided material on, where such backs are at most
/// one in 200 hits of such materials: more are the modeller's way, and seen from the room.
inline std::vector<std::uint8_t> behind_walls(const Scene& scene, const ParticleField& field) {
  std::vector<std::uint8_t> marked(field.candidates.size(), 0);
  std::size_t fronts = 0, backs = 0;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const TriangleSide side = field.candidates[i].side;
    if (scene.materials[scene.mesh.materials[side.triangle]].double_sided) continue;
    (side.front ? fronts : backs) += 1;
    marked[i] = !side.front;
  }
  if (200 * backs > fronts + backs) std::ranges::fill(marked, std::uint8_t(0));
  for (std::size_t i = 1; i < marked.size(); ++i)
    if (marked[i - 1] && field.particle[i] == field.particle[i - 1]) marked[i] = 1;
  return marked;
}

/// Marks candidates near which hardly any other particle hit what faces alike: at most two where twelve are
/// expected.
template <Executor E>
std::vector<std::uint8_t> lonely(const Mesh& mesh, const ParticleField& field, const E& executor) {
  std::vector<std::uint8_t> marked(field.candidates.size(), 0);
  const auto reach = float(std::sqrt(12 / double(pi) * 0.25 * cell_area(mesh, field.candidates)));
  if (!(reach > 0)) return marked;
  const NearSamples near(field.candidates, reach);
  executor(marked.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const SurfaceSample& s = field.candidates[i];
      int others = 0;
      near.for_each_within(s.position, reach, [&](std::uint32_t k, float) {
        others += field.particle[k] != field.particle[i] && faces_alike(s, field.candidates[k]);
      });
      marked[i] = others <= 2;
    }
  });
  return marked;
}

/// Marks ten or more lonely hits of a particle in a row, single others among them: it slipped into a solid,
/// or behind a wall, through a crack or by rounding, and hardly any other did. One on a wire or a leaf is
/// lonely too, but not ten. Only where many particles share the scene.
template <Executor E>
std::vector<std::uint8_t> alone_in_solids(const Mesh& mesh, const ParticleField& field, const E& executor) {
  constexpr std::size_t most = 10;
  std::vector<std::uint8_t> marked(field.candidates.size(), 0);
  if (field.traced < 64 || field.candidates.empty()) return marked;
  const auto alone = lonely(mesh, field, executor);
  for (std::size_t begin = 0, end = 0; begin < alone.size(); begin = std::max(end, begin + 1)) {
    const auto goes_on = [&](std::size_t i) {
      return i < alone.size() && field.particle[i] == field.particle[begin] && alone[i];
    };
    end = begin;
    while (goes_on(end) || (end > begin && goes_on(end + 1))) ++end;
    if (end - begin >= most)
      std::fill(marked.begin() + std::ptrdiff_t(begin), marked.begin() + std::ptrdiff_t(end),
                std::uint8_t(1));
  }
  return marked;
}

/// Gives all candidates the same area, and leaves some out where that takes it.
inline void set_areas(const Mesh& mesh, std::size_t starts, ParticleField& field) {
  const EvenCandidates even = even_out(mesh, field.candidates, starts, [&](std::size_t i) {
    return std::uint32_t(field.particle[i] % starts);
  });
  field.area = even.area;
  erase_marked(field, even.dropped);
  for (SurfaceSample& s : field.candidates) s.area = float(even.area / double(field.candidates.size()));
}

}  // namespace detail

/// Sends particles from the starting points, in turn, in all directions and lets every surface, both sides,
/// reflect them by Lambert's law. What they hit after their first reflections (PCA section 4.1) becomes a
/// candidate. In a closed room such hits are even by area, wherever the start is; rooms that no door joins
/// need a start each, and get candidates by their area. Alpha masks' holes are the tracer's business.
/// Fewer candidates where particles escape or stray, at most options.count; none without starts or
/// surfaces. The same bits for any executor. Cost: a ray a hit. Precondition: most_hits > reflections.
template <RayTracer T, Executor E>
ParticleField trace_particles(const Scene& scene, const T& tracer, std::span<const vec3> starts,
                              const E& executor, const ParticleOptions& options = {}) {
  COPPICE_ASSERT(options.most_hits > options.reflections);
  ParticleField field;
  if (starts.empty() || options.count == 0 || scene.mesh.triangles.empty()) return field;
  const detail::Ball ball = detail::ball_around(scene.mesh);
  field.sky = options.escape == Escape::sky || (options.escape == Escape::automatic &&
                                                !detail::is_closed(scene, tracer, starts, options, executor));
  std::vector<detail::ParticlePath> paths(std::clamp<std::size_t>(options.count / 256, 64, 1024));
  const std::size_t most = options.count + 1024;
  while (field.candidates.size() < options.count && field.traced < most) {
    detail::fly_all(scene, tracer, starts, field.sky ? &ball : nullptr, field.traced, paths, options,
                    executor);
    for (std::size_t i = 0; i < paths.size() && field.candidates.size() < options.count; ++i)
      detail::append(field, paths[i], options.count);
  }
  const std::size_t before = field.candidates.size();
  detail::erase_marked(field, detail::behind_walls(scene, field));
  detail::erase_marked(field, detail::alone_in_solids(scene.mesh, field, executor));
  field.stray = before - field.candidates.size();
  detail::set_areas(scene.mesh, field.sky ? 1 : starts.size(), field);
  executor(field.candidates.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      field.candidates[i].colour = diffuse_albedo(scene, field.candidates[i], options.shading);
  });
  return field;
}

}  // namespace coppice
