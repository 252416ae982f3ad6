// Gathering by solid angle: a register of points walks the tree together (Filtering section 2.2).
#pragma once

#include <coppice/gather/group_lists.hpp>
//
#include <coppice/tree/aggregate.hpp>
#include <coppice/tree/walk.hpp>

namespace coppice {

/// Marks of a node for the walk: whether its solid angle decides, or a min-max cut has decided.
enum class WalkMark : std::uint8_t { test, split, take };

/// Thresholds of the min-max cut (Filtering section 2.2) on the total normal variance of a cluster,
/// Σ |n - n̄|² over its VPLs: nodes above `min` are always split, nodes at most `max` are always taken.
struct MinMaxCut {
  float min = 40;
  float max = 9;
};

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// By heap id. Where VPLs have unit normals, Σ |n - n̄|² = count (1 - |n̄|²) with n̄ their plain mean.
inline std::vector<WalkMark> min_max_marks(const VplTree& tree, const MinMaxCut& cut) {
  const std::uint32_t leaves = tree.leaf_count();
  const auto sums = aggregate(
      leaves,
      [&](std::uint32_t i) {
        const VplNode& leaf = tree.nodes()[leaves + i];
        return leaf.energy > 0 ? vec4(leaf.normal, 1) : vec4(0);
      },
      [](const vec4& a, const vec4& b) { return a + b; });
  std::vector<WalkMark> marks(sums.size(), WalkMark::test);
  for (std::uint32_t h = 1; h < leaves; ++h) {
    const vec3 sum(sums[h]);
    const float variance = sums[h].w > 0 ? sums[h].w - dot(sum, sum) / sums[h].w : 0.0f;
    marks[h] = variance > cut.min ? WalkMark::split : variance <= cut.max ? WalkMark::take : WalkMark::test;
  }
  return marks;
}

/// Points side by side, one a lane, and what they reflect so far.
class PointPacket {
 public:
  /// Precondition: 1 to Lanes::width points; lanes beyond repeat the last.
  explicit PointPacket(std::span<const GlossyPoint> points) {
    const auto lanes = [&](auto&& value) {
      float values[Lanes::width];
      for (std::size_t i = 0; i < Lanes::width; ++i)
        values[i] = value(points[std::min(i, points.size() - 1)]);
      return Lanes::load(values);
    };
    const auto part = [&](auto member, int k) {
      return lanes([&](const GlossyPoint& p) { return (p.*member)[k]; });
    };
    using P = GlossyPoint;
    shape_ = {part(&P::position, 0), part(&P::position, 1),
              part(&P::position, 2), lanes([](const P& p) { return p.exponent; }),
              part(&P::normal, 0),   part(&P::normal, 1),
              part(&P::normal, 2),   part(&P::mirror, 0),
              part(&P::mirror, 1),   part(&P::mirror, 2)};
    for (int c = 0; c < 3; ++c) diffuse_[c] = part(&P::diffuse, c), specular_[c] = part(&P::specular, c);
  }

  /// Whether any point is nearer than the root of `squared` to the node.
  bool any_within(const VplNode& n, float squared) const {
    const Lanes x = n.position.x - shape_.x, y = n.position.y - shape_.y, z = n.position.z - shape_.z;
    return any(mul_add(x, x, mul_add(y, y, z * z)) < squared);
  }

  void add(const VplNode& n) {
    const VplShape<Lanes> node{n.position.x, n.position.y, n.position.z, n.variance, n.normal.x, n.normal.y,
                               n.normal.z,   n.softening,  n.lobe.x,     n.lobe.y,   n.lobe.z,   n.exponent};
    const VplArrival<Lanes> a = vpl_arrival(node, shape_);
    if (!any(a.geometry > 0.0f)) return;
    const VplTerms<Lanes> t = vpl_cluster_terms(node, shape_, a);
    for (int c = 0; c < 3; ++c)
      radiance_[c] = mul_add(mul_add(t.lobe, n.specular[c], n.diffuse[c]),
                             mul_add(diffuse_[c], t.diffuse, specular_[c] * t.specular), radiance_[c]);
  }

  void store(std::span<vec3> radiance) const {
    float values[3][Lanes::width];
    for (int c = 0; c < 3; ++c) radiance_[c].store(values[c]);
    for (std::size_t i = 0; i < radiance.size(); ++i)
      radiance[i] = {values[0][i], values[1][i], values[2][i]};
  }

 private:
  PointShape<Lanes> shape_;
  Lanes diffuse_[3], specular_[3], radiance_[3]{0.0f, 0.0f, 0.0f};
};

/// The unshadowed light of the VPLs at all points, in their order: a node is split where it covers more than
/// `threshold` steradians of any point of a packet, by vpl_reach. `marks`: by heap id, or empty. The same for
/// any executor. Precondition: 0 < threshold < 2π.
template <Executor E>
Gathered gather_by_angle(const VplTree& tree, std::span<const GlossyPoint> points, float threshold,
                         std::span<const WalkMark> marks, const E& executor) {
  COPPICE_ASSERT(threshold > 0 && threshold < 2 * pi);
  Gathered result{std::vector<vec3>(points.size()), std::vector<std::uint32_t>(points.size())};
  const float reach = vpl_reach(threshold);
  const std::size_t packets = (points.size() + Lanes::width - 1) / Lanes::width;
  std::vector<std::uint32_t> tests(packets);
  executor(packets, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const std::size_t first = p * Lanes::width, count = std::min(Lanes::width, points.size() - first);
      PointPacket packet(points.subspan(first, count));
      std::uint32_t taken = 0;
      walk_tree(tree.leaf_count(), [&](std::uint32_t h) {
        const VplNode& n = tree.nodes()[h];
        const WalkMark mark = marks.empty() ? WalkMark::test : marks[h];
        if (n.energy <= 0) return false;
        ++tests[p];
        const bool is_inner = h < tree.leaf_count() && mark != WalkMark::take;
        if (is_inner && (mark == WalkMark::split || packet.any_within(n, reach * n.area))) return true;
        packet.add(n), ++taken;
        return false;
      });
      packet.store(std::span(result.radiance).subspan(first, count));
      std::fill_n(result.nodes.begin() + std::ptrdiff_t(first), count, taken);
    }
  });
  result.tests = std::accumulate(tests.begin(), tests.end(), std::size_t{0});
  return result;
}

}  // namespace coppice::inline HWY_NAMESPACE
