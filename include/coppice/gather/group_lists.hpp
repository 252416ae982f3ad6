// For each group of points the nodes that are enough for it, and what each point reflects of them.
#pragma once

#include <coppice/gather/vpl_tree.hpp>
//
#include <coppice/core/parallel.hpp>
#include <coppice/gather/group_cut.hpp>
#include <coppice/gather/point_groups.hpp>
#include <coppice/gather/vpl_shade.hpp>
#include <numeric>

namespace coppice {

/// What came out, in the order of the groups' points.
struct Gathered {
  std::vector<vec3> radiance;
  std::vector<std::uint32_t> nodes;  ///< a point: nodes evaluated
  std::size_t tests = 0;             ///< nodes whose bound or solid angle was tested, over all groups
};

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// Cuts for groups of points: a node is split where an upper bound of what it brings to any of them, by
/// default times the root of the solid angle that it may cover, is above threshold · B. B is the luminance of
/// the group's light, estimated by 64 nodes at up to four of its points, but at least a hundredth of the mean
/// over all.
class GroupLists {
 public:
  template <Executor E>
  GroupLists(const VplTree& tree, const PointGroups& groups, float threshold, const E& executor,
             SplitBy split = SplitBy::bound_and_angle)
      : tree_(tree), groups_(groups), split_(split), limits_(groups.size()) {
    const std::uint32_t first = std::min(tree.leaf_count(), 64u);
    coarse_.reset(first);
    for (std::uint32_t h = first; h < 2 * first; ++h) coarse_.push(tree.nodes()[h]);
    coarse_.pad();
    executor(groups.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t g = begin; g < end; ++g) limits_[g] = estimate(groups.group(g));
    });
    const float least = least_share * mean_estimate();
    for (float& limit : limits_) limit = threshold * std::max(limit, least);
  }

  /// Calls visit(first point's index, points, heap ids) for groups [begin, end), and returns the tests.
  template <class Visit>
  std::size_t for_each(std::size_t begin, std::size_t end, Visit&& visit) const {
    GroupCutter cutter(tree_.blocks());
    std::size_t tests = 0;
    for (std::size_t g = begin; g < end && tree_.leaf_count() > 0; ++g) {
      const auto points = groups_.group(g);
      visit(groups_.first(g), points, cutter.cut(bound_of_points(points), limits_[g], split_));
      tests += cutter.tests();
    }
    return tests;
  }

 private:
  static constexpr float least_share = 0.01f;

  float estimate(std::span<const GlossyPoint> points) const {
    const std::size_t step = (points.size() + 3) / 4;
    float sum = 0;
    std::size_t count = 0;
    for (std::size_t i = step / 2; i < points.size(); i += step, ++count)
      sum += luminance(reflect_nodes<VplKind::cluster>(coarse_, points[i]));
    return sum / float(std::max<std::size_t>(count, 1));
  }

  float mean_estimate() const {
    double sum = 0;
    for (std::size_t g = 0; g < groups_.size(); ++g)
      sum += double(limits_[g]) * double(groups_.group(g).size());
    return groups_.points.empty() ? 0 : float(sum / double(groups_.points.size()));
  }

  const VplTree& tree_;
  const PointGroups& groups_;
  SplitBy split_;
  std::vector<float> limits_;
  VplArrays coarse_;
};

/// The unshadowed light of the VPLs at all points (Filtering Eq. 2), each group with its own cut. The same
/// for any executor. Threshold 0 evaluates every VPL that can bring anything.
template <Executor E>
Gathered gather_by_bound(const VplTree& tree, const PointGroups& groups, float threshold, const E& executor) {
  Gathered result{std::vector<vec3>(groups.points.size()), std::vector<std::uint32_t>(groups.points.size())};
  const GroupLists lists(tree, groups, threshold, executor);
  std::vector<std::size_t> tests(groups.size());
  executor(groups.size(), 16, [&](std::size_t begin, std::size_t end) {
    VplArrays nodes;
    tests[begin] = lists.for_each(begin, end, [&](std::size_t first, auto points, auto ids) {
      nodes.assign(tree.nodes(), ids);
      for (std::size_t i = 0; i < points.size(); ++i) {
        result.radiance[first + i] = reflect_nodes<VplKind::cluster>(nodes, points[i]);
        result.nodes[first + i] = std::uint32_t(ids.size());
      }
    });
  });
  result.tests = std::accumulate(tests.begin(), tests.end(), std::size_t{0});
  return result;
}

}  // namespace coppice::inline HWY_NAMESPACE
