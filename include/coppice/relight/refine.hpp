// Subdivides faces where visibility at an edge's middle differs from what interpolation gives.
#pragma once

#include <algorithm>
#include <coppice/relight/visibility_cuts.hpp>
#include <unordered_map>
#include <utility>

namespace coppice {

struct RefineOptions {
  double tolerance = 0.02;  ///< largest error of an edge's middle, as a share of unoccluded irradiance
  std::size_t max_receivers = 200000;  ///< budget; edges of largest error · length are split first
};

/// Lengths between which the tolerance decides, in world units. Longer edges are always split; shorter ones
/// only where they are the longest of a face that is split.
struct EdgeLimits {
  float shortest = 0;
  float longest = std::numeric_limits<float>::infinity();
};

/// What one point sees of the pilot lights.
struct PilotView {
  vec3 position;
  std::span<const std::uint64_t> seen;  ///< a bit a light
};

/// Error of irradiance at the middle of an edge if visibility is interpolated there, under a random light:
/// mean of |V_m - (V_a + V_b)/2| over the pilot lights, weighted by their cosine to the middle's shading
/// normal. In [0, 1]. Where a and b disagree interpolation is off by 1/2 whatever lies between; halving the
/// edge halves that share.
inline double edge_error(const DirectionPackets& pilot, const vec3& normal, const PilotView& a,
                         const PilotView& b, const PilotView& middle) {
  double error = 0;
  const auto add = [&](std::size_t word, std::uint64_t bits, double weight) {
    for (; bits != 0; bits &= bits - 1) {
      const auto light = std::uint32_t(64 * word) + std::uint32_t(std::countr_zero(bits));
      error += weight * std::max(0.0f, dot(normal, pilot.direction(light)));
    }
  };
  for (std::size_t w = 0; w < a.seen.size(); ++w) {
    const std::uint64_t differ = a.seen[w] ^ b.seen[w];
    add(w, differ, 0.5);
    add(w, ~differ & (a.seen[w] ^ middle.seen[w]), 1.0);
  }
  return error / (0.25 * pilot.count());  // the mean of max(0, cos) over the sphere is 1/4
}

namespace detail {

/// The rounds of refine_receivers. Visibility is sampled by few pilot lights, kept a row a corner.
template <Occluder O, LightPackets L, Executor E, class Limits>
class Refiner {
 public:
  Refiner(ReceiverMesh& mesh, const O& occluder, const L& pilot, const RefineOptions& options,
          const Limits& limits, const E& executor)
      : mesh_(mesh),
        occluder_(occluder),
        pilot_(pilot),
        options_(options),
        limits_(limits),
        executor_(executor) {}

  void run() {
    while (split_worst(failing_edges())) {
    }
  }

 private:
  struct Edge {
    std::uint32_t a, b;  ///< corners, a < b
    FacesAround around;
    float length = 0;
    double error = 0;
    bool must_split = false;
  };

  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t(std::min(a, b)) << 32 | std::max(a, b);
  }
  std::size_t row_words() const { return words_for_bits(pilot_.count()); }
  PilotView view(std::uint32_t corner) const {
    return {mesh_.corners()[corner].position, {rows_.data() + corner * row_words(), row_words()}};
  }
  vec3 middle(const Edge& e) const {
    return 0.5f * (mesh_.corners()[e.a].position + mesh_.corners()[e.b].position);
  }
  vec3 middle_normal(const Edge& e) const {
    const vec3 a = mesh_.corners()[e.a].normal, b = mesh_.corners()[e.b].normal;
    return normalize_or(a + b, a);
  }

  /// Edges of the faces without children, in order of their first appearance.
  std::vector<Edge> open_edges() const {
    std::vector<Edge> edges;
    std::unordered_map<std::uint64_t, std::size_t> index;
    for (std::uint32_t f = 0; f < mesh_.faces().size(); ++f) {
      if (!mesh_.is_leaf(f)) continue;
      const auto& face = mesh_.faces()[f];
      for (int k = 0; k < 3; ++k) add_edge(edges, index, face, face.corners[k], face.corners[(k + 1) % 3]);
    }
    return edges;
  }

  void add_edge(std::vector<Edge>& edges, std::unordered_map<std::uint64_t, std::size_t>& index,
                const ReceiverMesh::Face& face, std::uint32_t a, std::uint32_t b) const {
    const auto [it, is_new] = index.try_emplace(key(a, b), edges.size());
    if (is_new) edges.push_back({std::min(a, b), std::max(a, b), {}, 0, 0, false});
    Edge& e = edges[it->second];
    e.around.add(middle(e), face.normal, face_centroid(mesh_, face));
  }

  /// Edges within the limits that are too long or miss the tolerance.
  std::vector<Edge> failing_edges() {
    trace_new_corners();
    std::vector<Edge> edges = open_edges();
    for (Edge& e : edges) e.length = length(mesh_.corners()[e.a].position - mesh_.corners()[e.b].position);
    std::erase_if(edges, [&](Edge& e) {
      const EdgeLimits limits = limits_(middle(e));
      e.must_split = e.length > limits.longest;
      return e.a == e.b || !(e.length > limits.shortest) || settled_.contains(key(e.a, e.b));
    });
    measure(edges);
    std::erase_if(edges, [&](const Edge& e) {
      const bool fails = e.must_split || e.error > options_.tolerance;
      if (!fails) settled_.emplace(key(e.a, e.b), true);
      return !fails;
    });
    return edges;
  }

  void trace_new_corners() {
    std::vector<Receiver> receivers = corner_receivers(mesh_);
    const std::size_t known = rows_.size() / row_words();
    rows_.resize(receivers.size() * row_words());
    trace(std::span<const Receiver>(receivers).subspan(known),
          [&](std::size_t i, std::span<const std::uint64_t> bits) {
            std::ranges::copy(bits, rows_.begin() + std::ptrdiff_t((known + i) * row_words()));
          });
  }

  void measure(std::vector<Edge>& edges) {
    std::vector<Receiver> middles;
    for (const Edge& e : edges) {
      middles.push_back(middle_receiver(middle(e), middle_normal(e), e.around));
      middles.back().horizon = -1;
    }
    trace(middles, [&](std::size_t i, std::span<const std::uint64_t> bits) {
      edges[i].error = edge_error(pilot_, middle_normal(edges[i]), view(edges[i].a), view(edges[i].b),
                                  PilotView{middle(edges[i]), bits});
    });
  }

  template <class Consume>
  void trace(std::span<const Receiver> receivers, Consume&& consume) {
    for_each_visibility(occluder_, pilot_, receivers, executor_, consume, [](std::size_t, std::size_t) {});
  }

  using Middles = std::unordered_map<std::uint64_t, std::uint32_t>;

  /// Splits as many of the edges as the budget allows; false where there is nothing left to do.
  bool split_worst(std::vector<Edge> edges) {
    if (edges.size() > budget_left()) {
      const auto worse = [](const Edge& x, const Edge& y) { return x.error * x.length > y.error * y.length; };
      std::ranges::stable_sort(edges, worse);
      edges.resize(budget_left());
    }
    if (edges.empty()) return false;
    Middles middle_of;
    for (const Edge& e : edges) middle_of[key(e.a, e.b)] = mesh_.add_corner({middle(e), middle_normal(e)});
    while (split_longest_edges(middle_of)) {
    }
    const std::uint32_t faces = std::uint32_t(mesh_.faces().size());
    for (std::uint32_t f = 0; f < faces; ++f)
      if (mesh_.is_leaf(f)) split_face(f, middle_of);
    return true;
  }

  std::size_t budget_left() const {
    return options_.max_receivers - std::min(options_.max_receivers, mesh_.corners().size());
  }

  /// A face that is split at all is split at its longest edge too, or refinement would end in slivers that
  /// never meet the tolerance (Rivara 1984). True where an edge was added, which may concern a neighbour.
  bool split_longest_edges(Middles& middle_of) {
    bool added = false;
    for (std::uint32_t f = 0; f < mesh_.faces().size(); ++f) {
      if (!mesh_.is_leaf(f)) continue;
      const auto& c = mesh_.faces()[f].corners;
      const bool is_split = middle_of.contains(key(c.x, c.y)) || middle_of.contains(key(c.y, c.z)) ||
                            middle_of.contains(key(c.z, c.x));
      const int k = longest_edge(c);
      const Edge e{std::min(c[k], c[(k + 1) % 3]), std::max(c[k], c[(k + 1) % 3]), {}, 0, 0, false};
      if (!is_split || middle_of.contains(key(e.a, e.b)) || budget_left() == 0) continue;
      middle_of[key(e.a, e.b)] = mesh_.add_corner({middle(e), middle_normal(e)});
      added = true;
    }
    return added;
  }

  /// k where the edge from corner k to corner k + 1 is the longest; faces that share it agree on ties.
  int longest_edge(const uvec3& c) const {
    const auto rank = [&](int k) {
      const std::uint32_t a = c[k], b = c[(k + 1) % 3];
      const vec3 d = mesh_.corners()[a].position - mesh_.corners()[b].position;
      return std::pair(dot(d, d), key(a, b));
    };
    int longest = 0;
    for (int k = 1; k < 3; ++k)
      if (rank(longest) < rank(k)) longest = k;
    return longest;
  }

  using Vertex = std::pair<std::uint32_t, vec2>;  ///< corner and its (u, v)

  /// Seen from its longest edge, split at m: m is joined to the opposite corner, and to the middle of each
  /// other edge that is split.
  void split_face(std::uint32_t f, const Middles& middle_of) {
    const ReceiverMesh::Face face = mesh_.faces()[f];
    const auto find = [&](std::size_t i, std::size_t j) {
      return middle_of.find(key(face.corners[int(i)], face.corners[int(j)]));
    };
    const auto vertex = [&](std::size_t i) { return Vertex{face.corners[int(i)], face.uv[i]}; };
    const auto middle_vertex = [&](std::size_t i, std::size_t j) {
      return Vertex{find(i, j)->second, 0.5f * (face.uv[i] + face.uv[j])};
    };
    const auto is_split = [&](std::size_t i, std::size_t j) { return find(i, j) != middle_of.end(); };
    std::size_t i = std::size_t(longest_edge(face.corners));
    for (int turn = 0; turn < 2 && !is_split(i, (i + 1) % 3); ++turn)
      i = (i + 1) % 3;  // only a spent budget leaves it whole
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    if (!is_split(i, j)) return;
    const Vertex m = middle_vertex(i, j);
    std::vector<ReceiverMesh::Face> children;
    const auto add = [&](const Vertex& a, const Vertex& b, const Vertex& c) {
      children.push_back(
          {uvec3(a.first, b.first, c.first), {a.second, b.second, c.second}, face.normal, face.triangle});
    };
    const auto add_half = [&](std::size_t from, std::size_t to) {
      if (!is_split(from, to)) return add(m, vertex(from), vertex(to));
      add(m, vertex(from), middle_vertex(from, to));
      add(m, middle_vertex(from, to), vertex(to));
    };
    add_half(j, k);
    add_half(k, i);
    mesh_.subdivide(f, children);
  }

  ReceiverMesh& mesh_;
  const O& occluder_;
  const L& pilot_;
  RefineOptions options_;
  const Limits& limits_;
  const E& executor_;
  std::vector<std::uint64_t> rows_;
  std::unordered_map<std::uint64_t, bool> settled_;
};

}  // namespace detail

/// Splits edges in rounds until every edge within limits(position) meets the tolerance, or the budget of
/// receivers is spent. Faces that share an edge are split at the same corner, so interpolation stays
/// continuous. Visibility is judged by the pilot lights, a few of all: 2,048 tell a share of 2% to a fifth of
/// it. Deterministic.
template <Occluder O, LightPackets L, Executor E, class Limits>
void refine_receivers(ReceiverMesh& mesh, const O& occluder, const L& pilot, const RefineOptions& options,
                      const Limits& limits, const E& executor) {
  if (mesh.faces().empty() || pilot.count() == 0) return;
  detail::Refiner<O, L, E, Limits>(mesh, occluder, pilot, options, limits, executor).run();
}

}  // namespace coppice
