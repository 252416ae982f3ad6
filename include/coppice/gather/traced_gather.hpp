// Gathering with shadows: one ray a cluster, to one of its VPLs.
#pragma once

#include <coppice/gather/group_lists.hpp>
//
#include <coppice/core/random.hpp>
#include <coppice/scene/occluder.hpp>

namespace coppice {

/// Which VPL of a cluster the ray goes to.
enum class VplChoice {
  energy,       ///< drawn by energy
  contribution  ///< a register of VPLs drawn by energy, of these one by what it would bring without shadows
};

namespace detail {

/// What free rays have brought.
struct Carried {
  glm::dvec3 radiance{0};
  glm::dvec3 towards{0};  ///< Σ luminance · direction
};

}  // namespace detail

}  // namespace coppice

namespace coppice::detail::inline HWY_NAMESPACE {

/// Rays from one point that carry radiance, traced sixteen at a time.
template <Occluder O>
class CarryingRays {
 public:
  CarryingRays(const O& occluder, const vec3& origin) : occluder_(occluder) {
    std::fill_n(packet_.origin_x, 16, origin.x);
    std::fill_n(packet_.origin_y, 16, origin.y);
    std::fill_n(packet_.origin_z, 16, origin.z);
  }

  /// Precondition: the target is not the origin.
  void add(const vec3& target, const vec3& radiance) {
    const vec3 origin(packet_.origin_x[0], packet_.origin_y[0], packet_.origin_z[0]), way = target - origin;
    const float distance = length(way);
    packet_.direction_x[count_] = way.x / distance;
    packet_.direction_y[count_] = way.y / distance;
    packet_.direction_z[count_] = way.z / distance;
    packet_.t_max[count_] = distance * (1 - 1e-4f);
    radiance_[count_] = radiance;
    if (++count_ == 16) trace();
  }

  const Carried& arrived() {
    if (count_ > 0) trace();
    return sum_;
  }
  std::uint32_t traced() const { return traced_; }

 private:
  void trace() {
    const std::uint32_t lanes = (1u << count_) - 1, free = lanes & ~occluder_.occluded(packet_, lanes);
    for (std::uint32_t i = 0; i < count_; ++i) {
      if (!(free >> i & 1)) continue;
      const glm::dvec3 d(packet_.direction_x[i], packet_.direction_y[i], packet_.direction_z[i]);
      sum_.radiance += glm::dvec3(radiance_[i]);
      sum_.towards += double(luminance(radiance_[i])) * d;
    }
    traced_ += count_;
    count_ = 0;
  }

  const O& occluder_;
  ShadowPacket packet_{};
  std::array<vec3, 16> radiance_;
  std::uint32_t count_ = 0, traced_ = 0;
  Carried sum_;
};

}  // namespace coppice::detail::inline HWY_NAMESPACE

namespace coppice::inline HWY_NAMESPACE {

/// What a point reflects of clusters that it sees in part: a ray goes to one VPL of each, which counts as
/// often as it was unlikely. Without bias: the mean over the draws is the sum over all VPLs that are seen. (A
/// ray to a cluster's mean position, which lies behind what is convex, is not.) No ray goes to what brings
/// nothing.
class TracedNodes {
 public:
  /// Lays the leaves out by rank. The tree must outlive it.
  TracedNodes(const VplTree& tree, VplChoice choice)
      : tree_(tree), block_(choice == VplChoice::energy ? 1u : std::uint32_t(Lanes::width)) {
    leaves_.reset(tree.leaf_count());
    for (std::uint32_t i = 0; i < tree.leaf_count(); ++i) leaves_.push(tree.nodes()[tree.leaf_count() + i]);
    leaves_.pad();
  }

  /// `ids`: heap ids, disjoint. Adds the rays that it took to `rays`.
  template <Occluder O>
  detail::Carried arrive(const GlossyPoint& point, std::span<const std::uint32_t> ids, Random random,
                         const O& occluder, std::uint32_t& rays) const {
    detail::CarryingRays<O> carried(occluder, point.position);
    const PointShape<Lanes> shape = point_lanes(point);
    float u = random.uniform();  // the next is a golden section on: evenly spread over the clusters
    for (const std::uint32_t id : ids) {
      add_one(id, u, point, shape, carried);
      u += 0.618034f;
      u -= std::floor(u);
    }
    const detail::Carried arrived = carried.arrived();
    rays += carried.traced();
    return arrived;
  }

  template <Occluder O>
  vec3 reflect(const GlossyPoint& point, std::span<const std::uint32_t> ids, Random random, const O& occluder,
               std::uint32_t& rays) const {
    return vec3(arrive(point, ids, random, occluder, rays).radiance);
  }

 private:
  /// A node of at most block_ leaves below h, drawn by energy, and how often it counts.
  struct Drawn {
    std::uint32_t node;
    float times;
    float u;  ///< what is left of the random number
  };
  Drawn draw_below(std::uint32_t h, float u) const {
    const float energy = tree_.nodes()[h].energy;
    std::uint32_t size = leaves_below(tree_.leaf_count(), h).size();
    for (; size > block_; size /= 2) {
      const float share = vpl_share(tree_.nodes()[2 * h].energy, tree_.nodes()[2 * h + 1].energy);
      const bool is_left = u < share;
      u = is_left ? u / share : (u - share) / std::max(1 - share, 1e-30f);
      h = 2 * h + !is_left;
    }
    const float drawn = tree_.nodes()[h].energy;
    return {h, drawn > 0 ? energy / drawn : 0.0f, u};
  }

  template <Occluder O>
  void add_one(std::uint32_t id, float u, const GlossyPoint& point, const PointShape<Lanes>& shape,
               detail::CarryingRays<O>& carried) const {
    const Drawn drawn = draw_below(id, u);
    const LeafRange range = leaves_below(tree_.leaf_count(), drawn.node);
    const std::size_t begin = range.begin / Lanes::width * Lanes::width, from = range.begin - begin;
    const VplLanes n = leaves_.load(begin);
    VplArrival<Lanes> a = vpl_arrival(n.shape, shape);
    const LaneMask inside = first_lanes(from + range.size()) & !first_lanes(from);
    if (!any(inside & (a.geometry > 0.0f))) return;
    const VplTerms<Lanes> t = vpl_terms(n.shape, shape, a);
    float brought[3][Lanes::width], weight[Lanes::width];
    Lanes sum = 0.0f;
    for (int c = 0; c < 3; ++c) {
      const Lanes shining = mul_add(n.specular[c], t.lobe, n.diffuse[c]);
      const Lanes seen =
          shining * mul_add(Lanes(point.diffuse[c]), t.diffuse, point.specular[c] * t.specular);
      seen.store(brought[c]);
      sum = mul_add(seen, Lanes(vpl_luminance(vec3(c == 0, c == 1, c == 2))), sum);
    }
    sum = select(inside, sum, 0.0f);
    sum.store(weight);
    const float total = sum_of_lanes(sum);
    if (!(total > 0)) return;
    const std::size_t i = pick(weight, drawn.u * total, from, from + range.size());
    const std::uint32_t leaf = tree_.leaf_count() + std::uint32_t(begin + i);
    // The division first: total / weight may overflow.
    const vec3 colour = vec3(brought[0][i], brought[1][i], brought[2][i]) / weight[i];
    carried.add(tree_.nodes()[leaf].position, drawn.times * total * colour);
  }

  /// The item at which the sum of weights reaches `at`; one with a weight above 0.
  static std::size_t pick(const float* weight, float at, std::size_t begin, std::size_t end) {
    std::size_t last = begin;
    for (std::size_t i = begin; i < end; ++i) {
      if (!(weight[i] > 0)) continue;
      last = i;
      if ((at -= weight[i]) < 0) break;
    }
    return last;
  }

  const VplTree& tree_;
  std::uint32_t block_;
  VplArrays leaves_;
};

/// The light of the VPLs that each point sees. `nodes` of the result counts rays. The same for any executor:
/// what is drawn depends on the seed and on a point's pixel alone.
template <Occluder O, Executor E>
Gathered gather_traced(const VplTree& tree, const PointGroups& groups, float threshold, VplChoice choice,
                       const O& occluder, std::uint64_t seed, const E& executor) {
  Gathered result{std::vector<vec3>(groups.points.size()), std::vector<std::uint32_t>(groups.points.size())};
  const GroupLists lists(tree, groups, threshold, executor, SplitBy::bound);
  const TracedNodes traced(tree, choice);
  std::vector<std::size_t> tests(groups.size());
  executor(groups.size(), 4, [&](std::size_t begin, std::size_t end) {
    tests[begin] = lists.for_each(begin, end, [&](std::size_t first, auto points, auto ids) {
      for (std::size_t i = 0; i < points.size(); ++i)
        result.radiance[first + i] = traced.reflect(
            points[i], ids, Random(Random(seed + points[i].pixel).bits()), occluder, result.nodes[first + i]);
    });
  });
  result.tests = std::accumulate(tests.begin(), tests.end(), std::size_t{0});
  return result;
}

}  // namespace coppice::inline HWY_NAMESPACE
