// Further bounces: the light of VPLs gathered at the VPLs themselves.
#pragma once

#include <coppice/gather/traced_gather.hpp>

namespace coppice {

/// What arrives of both lights together.
inline VplLight together(const VplLight& a, const VplLight& b) {
  const float la = luminance(a.irradiance), lb = luminance(b.irradiance), share = vpl_share(la, lb);
  const LobeShape mean = lobe_sum({a.direction, lobe_exponent(a.shortfall)}, share,
                                  {b.direction, lobe_exponent(b.shortfall)}, 1 - share);
  return {a.irradiance + b.irradiance, lobe_shortfall(mean.exponent), mean.direction};
}

/// A VPL as a point that receives light: what it reflects is its irradiance.
inline GlossyPoint receiving_point(const SurfaceSample& vpl, std::uint32_t index) {
  GlossyPoint p{};
  p.position = ray_origin(vpl);
  p.normal = p.mirror = vpl.normal;
  p.exponent = 1;
  p.pixel = index;
  p.diffuse = vec3(pi);
  return p;
}

/// Irradiance and its mean direction by luminance; in the dark, the normal.
inline VplLight mean_light(const detail::Carried& carried, const vec3& normal) {
  const vec3 irradiance(carried.radiance);
  const double size = length(carried.towards), weight = double(luminance(irradiance));
  if (!(size > 0)) return {irradiance, 1, normal};
  return {irradiance, float(std::clamp(1 - size / weight, 0.0, 1.0)), vec3(carried.towards / size)};
}

/// The leaves that shine, in their order.
inline std::vector<VplNode> shining(std::vector<VplNode> leaves) {
  std::erase_if(leaves, [](const VplNode& leaf) { return leaf.energy <= 0; });
  return leaves;
}

/// VPLs in groups of up to 32 that lie close together and face alike; `pixel` is a VPL's index.
inline PointGroups group_vpls(std::span<const SurfaceSample> vpls) {
  constexpr std::size_t most = 32;
  std::vector<LightSample> samples;
  for (const SurfaceSample& s : vpls) samples.push_back({s.position, s.normal});
  const LightTree tree = build_tree(GeometricMetric(samples, 6));
  PointGroups groups;
  std::size_t begin = 0;
  for (const std::uint32_t i : tree.light_of_leaf) {
    if (i == no_light) continue;
    const std::size_t count = groups.points.size() - begin;
    if (count == most || (count > 0 && dot(groups.points[begin].normal, vpls[i].normal) < 0.9f)) {
      begin = groups.points.size();
      groups.ends.push_back(std::uint32_t(begin));
    }
    groups.points.push_back(receiving_point(vpls[i], i));
  }
  if (groups.points.size() > begin) groups.ends.push_back(std::uint32_t(groups.points.size()));
  return groups;
}

}  // namespace coppice

namespace coppice::inline HWY_NAMESPACE {

/// What arrives at a point of the nodes, unshadowed: irradiance, and its mean direction by luminance.
inline VplLight receive_nodes(const VplArrays& nodes, const GlossyPoint& point) {
  const PointShape<Lanes> shape = point_lanes(point);
  Lanes sums[6]{0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  for (std::size_t i = 0; i < nodes.size(); i += Lanes::width) {
    const VplLanes n = nodes.load(i);
    const VplArrival<Lanes> a = vpl_arrival(n.shape, shape);
    if (!any(a.geometry > 0.0f)) continue;
    const Lanes lobe = vpl_cluster_terms(n.shape, shape, a).lobe;
    Lanes arriving[3];
    for (int c = 0; c < 3; ++c) arriving[c] = mul_add(n.specular[c], lobe, n.diffuse[c]) * a.geometry;
    const Lanes weight = 0.2126f * arriving[0] + 0.7152f * arriving[1] + 0.0722f * arriving[2];
    const Lanes towards[] = {a.x, a.y, a.z};
    for (int c = 0; c < 3; ++c)
      sums[c] += arriving[c], sums[c + 3] = mul_add(weight, towards[c], sums[c + 3]);
  }
  const auto sum = [&](int k) {
    return vec3(sum_of_lanes(sums[k]), sum_of_lanes(sums[k + 1]), sum_of_lanes(sums[k + 2]));
  };
  const vec3 irradiance = sum(0), mean = sum(3);
  return mean_light({glm::dvec3(irradiance), glm::dvec3(mean)}, point.normal);
}

/// How VPLs are lit by VPLs.
struct BounceGather {
  int bounces = 1;          ///< of the light that VPLs send out: 1 is direct light alone
  float threshold = 0.02f;  ///< of GroupLists
  bool is_traced = false;   ///< otherwise without shadows
  std::uint64_t seed = 0;
  VplTreeOptions tree{};
};

/// What arrives at each VPL of the nodes' light.
template <Occluder O, Executor E>
std::vector<VplLight> receive_at_vpls(const VplTree& tree, const PointGroups& vpls,
                                      const BounceGather& options, const O& occluder, const E& executor) {
  std::vector<VplLight> light(vpls.points.size());
  const GroupLists lists(tree, vpls, options.threshold, executor,
                         options.is_traced ? SplitBy::bound : SplitBy::bound_and_angle);
  const TracedNodes traced(tree, VplChoice::contribution);
  executor(vpls.size(), 4, [&](std::size_t begin, std::size_t end) {
    VplArrays nodes;
    lists.for_each(begin, end, [&](std::size_t, auto points, auto ids) {
      if (!options.is_traced) nodes.assign(tree.nodes(), ids);
      for (const GlossyPoint& p : points) {
        if (!options.is_traced) {
          light[p.pixel] = receive_nodes(nodes, p);
          continue;
        }
        std::uint32_t rays = 0;
        const Random random(Random(options.seed + p.pixel).bits());
        light[p.pixel] = mean_light(traced.arrive(p, ids, random, occluder, rays), p.normal);
      }
    });
  });
  return light;
}

/// The light at VPLs after further bounces: what arrives directly, and what VPLs lit by all of it send to
/// each other (Filtering section 2.2, "Multi-Bounce Indirect Lighting"). `leaves(light)` makes the leaves of
/// all VPLs. VPLs without light are left out of the tree.
template <class Leaves, Occluder O, Executor E>
std::vector<VplLight> with_bounces(std::span<const SurfaceSample> vpls, std::span<const VplLight> direct,
                                   Leaves&& leaves, const BounceGather& options, const O& occluder,
                                   const E& executor) {
  std::vector<VplLight> light(direct.begin(), direct.end());
  if (options.bounces <= 1) return light;
  const PointGroups groups = group_vpls(vpls);
  for (int bounce = 1; bounce < options.bounces; ++bounce) {
    const VplTree tree(shining(leaves(std::span<const VplLight>(light))), options.tree);
    const auto received = receive_at_vpls(tree, groups, options, occluder, executor);
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = together(direct[i], received[i]);
  }
  return light;
}

}  // namespace coppice::inline HWY_NAMESPACE
