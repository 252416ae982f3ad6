#include <support/report.hpp>
#include <support/vpl_study.hpp>

namespace coppice::program {

namespace {

VplArrays arrays_of(std::span<const VplNode> nodes) {
  std::vector<std::uint32_t> ids(nodes.size());
  std::iota(ids.begin(), ids.end(), 0u);
  VplArrays arrays;
  arrays.assign(nodes, ids);
  return arrays;
}

/// In the order of a tree, so that registers of VPLs lie close together and can be passed over whole.
std::vector<VplNode> ordered(std::span<const VplNode> leaves) {
  const LightTree tree = detail::cluster_vpls(leaves, {});
  std::vector<VplNode> result;
  for (const std::uint32_t i : tree.light_of_leaf)
    if (i != no_light) result.push_back(leaves[i]);
  return result;
}

double brute_microseconds(const VplArrays& all, std::span<const GlossyPoint> points, std::size_t stride,
                          std::vector<vec3>& radiance) {
  Stopwatch watch;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); i += stride, ++count)
    radiance[i] = reflect_nodes<VplKind::single>(all, points[i]);
  return 1e6 * watch.lap() / double(std::max<std::size_t>(count, 1));
}

}  // namespace

std::vector<GlossyPoint> spread_points(const VplSubject& s, std::size_t count) {
  constexpr std::uint32_t side = 16;
  const auto width = std::uint32_t(s.raster.width), columns = (width + side - 1) / side;
  const auto tile_of = [&](const GlossyPoint& p) {
    return p.pixel / width / side * columns + p.pixel % width / side;
  };
  const std::size_t stride = std::max<std::size_t>(1, s.points.size() / std::max<std::size_t>(count, 1));
  std::vector<GlossyPoint> chosen;
  for (const GlossyPoint& p : s.points)
    if (tile_of(p) % stride == stride / 2) chosen.push_back(p);
  if (!chosen.empty() || s.points.empty()) return chosen;
  const std::uint32_t middle = tile_of(s.points[s.points.size() / 2]);  // where a stride is the whole image
  std::ranges::copy_if(s.points, std::back_inserter(chosen),
                       [&](const auto& p) { return tile_of(p) == middle; });
  return chosen;
}

BruteForce sum_all(const VplSubject& s, std::span<const GlossyPoint> points, int repeat) {
  std::vector<VplNode> leaves = ordered(s.leaves);
  const VplArrays shining = arrays_of(leaves);
  // What is dark costs what any other VPL costs: it is found out by evaluating it.
  for (std::size_t i = 0; !leaves.empty() && leaves.size() < s.placed; ++i)
    leaves.push_back(VplNode(leaves[i]));
  const VplArrays all = arrays_of(leaves);
  BruteForce brute{std::vector<vec3>(points.size())};
  std::vector<double> times, times_all;
  std::vector<vec3> ignored(points.size());
  for (int i = 0; i < repeat; ++i) {
    times.push_back(brute_microseconds(shining, points, 1, brute.radiance));
    times_all.push_back(brute_microseconds(all, points, 4, ignored));
  }
  brute.microseconds = median(times), brute.microseconds_all = median(times_all);
  return brute;
}

std::vector<vec3> sum_all_traced(const VplSubject& s, std::span<const GlossyPoint> points,
                                 const EmbreeTracer& tracer, const Threads& threads) {
  const VplTree tree(s.leaves);
  const TracedNodes traced(tree, VplChoice::energy);
  std::vector<std::uint32_t> ids(tree.leaf_count());
  std::iota(ids.begin(), ids.end(), tree.leaf_count());
  std::vector<vec3> radiance(points.size());
  threads(points.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::uint32_t rays = 0;
    for (std::size_t i = begin; i < end; ++i)
      radiance[i] = traced.reflect(points[i], ids, Random(0), tracer, rays);
  });
  return radiance;
}

std::vector<vec3> gather_at(const VplSubject& s, const VplTree& tree, std::span<const GlossyPoint> points,
                            const GatherSetting& setting, const EmbreeTracer& tracer,
                            std::vector<std::uint32_t>& nodes, std::size_t& tests,
                            const GroupOptions& options) {
  std::vector<GlossyPoint> numbered(points.begin(), points.end());
  const PointGroups groups = group_points(numbered, s.raster.width, s.camera.position, options);
  std::vector<WalkMark> marks;
  if (setting.min_max) marks = min_max_marks(tree, *setting.min_max);
  const Serial one;
  const Gathered g = setting.traced
                         ? gather_traced(tree, groups, setting.threshold, *setting.traced, tracer, 0, one)
                     : setting.criterion == Criterion::bound
                         ? gather_by_bound(tree, groups, setting.threshold, one)
                         : gather_by_angle(tree, groups.points, setting.threshold, marks, one);
  std::vector<std::uint32_t> at(s.raster.pixel_count());
  for (std::uint32_t i = 0; i < points.size(); ++i) at[points[i].pixel] = i;
  std::vector<vec3> radiance(points.size());
  nodes.resize(points.size());
  for (std::size_t i = 0; i < groups.points.size(); ++i) {
    radiance[at[groups.points[i].pixel]] = g.radiance[i];
    nodes[at[groups.points[i].pixel]] = g.nodes[i];
  }
  tests = g.tests;
  return radiance;
}

ImageErrors point_errors(std::span<const vec3> values, std::span<const vec3> reference) {
  Image x(int(values.size()), 1), r(int(values.size()), 1);
  x.pixels.assign(values.begin(), values.end());
  r.pixels.assign(reference.begin(), reference.end());
  return image_errors(x, r, std::vector<bool>(values.size(), true));
}

double relative_bias(std::span<const vec3> values, std::span<const vec3> reference) {
  double sum = 0, reference_sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    sum += double(luminance(values[i])), reference_sum += double(luminance(reference[i]));
  return reference_sum > 0 ? sum / reference_sum - 1 : 0;
}

GatherMeasurement measure_gather(const VplSubject& s, const VplTree& tree,
                                 std::span<const GlossyPoint> points, std::span<const vec3> reference,
                                 const GatherSetting& setting, const EmbreeTracer& tracer, int repeat) {
  GatherMeasurement m{setting};
  std::vector<std::uint32_t> nodes;
  std::vector<vec3> radiance;
  std::vector<double> times;
  std::size_t tests = 0;
  for (int i = 0; i < repeat; ++i) {
    Stopwatch watch;
    radiance = gather_at(s, tree, points, setting, tracer, nodes, tests);
    times.push_back(1e6 * watch.lap() / double(points.size()));
  }
  const CountSummary summary = summary_of(nodes);
  m.least = summary.min, m.most = summary.max, m.mean = summary.mean;
  m.tests = double(tests) / double(points.size());
  m.microseconds = median(times);
  m.errors = point_errors(radiance, reference);
  m.bias = relative_bias(radiance, reference);
  return m;
}

}  // namespace coppice::program
