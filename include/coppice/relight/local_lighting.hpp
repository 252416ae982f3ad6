// The lights of the scene summed up their tree, and brought up to date where some of them change.
#pragma once

#include <coppice/light/local_light.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <coppice/tree/metric.hpp>
#include <coppice/tree/refit.hpp>
#include <limits>

namespace coppice {

/// The lights as the geometric metric sees them: positions, and normals where they have one. Lights at
/// infinity stand on a ball around the scene.
inline std::vector<LightSample> metric_samples(std::span<const LocalLight> lights) {
  std::vector<LightSample> samples;
  samples.reserve(lights.size());
  for (const LocalLight& l : lights) samples.push_back({l.position, normalize_or(l.axis, vec3(0))});
  return samples;
}

namespace detail {

/// Means below a node, weighted by luminance and joined without cancellation (Moments), in double. All of an
/// unlit node are 0.
struct LocalLightSum {
  double luminance = 0;
  glm::dvec3 power{0}, position{0}, axis{0};
  double w = 0, offset = 0, square = 0, softening = 0;
  double variance = 0;
  double radius = 0;

  static LocalLightSum of(const LocalLight& l) {
    const glm::dvec3 power(l.intensity);
    const double lum = 0.2126 * power.x + 0.7152 * power.y + 0.0722 * power.z;
    if (!(lum > 0)) return {};
    return {lum, power, l.position, l.axis, l.w, l.offset, l.square, double(l.area) / std::numbers::pi, 0, 0};
  }

  friend LocalLightSum operator+(const LocalLightSum& a, const LocalLightSum& b) {
    if (!(a.luminance > 0)) return b;
    if (!(b.luminance > 0)) return a;
    const double lum = a.luminance + b.luminance, share = b.luminance / lum;
    const auto mean = [share](const auto& of_a, const auto& of_b) { return of_a + (of_b - of_a) * share; };
    const glm::dvec3 position = mean(a.position, b.position), apart = b.position - a.position;
    return {lum,
            a.power + b.power,
            position,
            mean(a.axis, b.axis),
            mean(a.w, b.w),
            mean(a.offset, b.offset),
            mean(a.square, b.square),
            mean(a.softening, b.softening),
            mean(a.variance, b.variance) + glm::dot(apart, apart) * (share * (1 - share)),
            std::max(glm::length(position - a.position) + a.radius,
                     glm::length(position - b.position) + b.radius)};
  }
};

}  // namespace detail

using LocalFrameLighting = LightingOf<LocalLightNode>;

/// Local lights on a tree: sums by heap id, in the forms that kernels read. A light that changes costs the
/// nodes above it: 17 for 65,536 lights. Where lights have moved far, the tree that was built for the old
/// positions still gives right sums, of worse clusters.
class LocalLighting {
 public:
  LocalLighting() = default;

  /// `lights` by index. The tree must outlive this.
  LocalLighting(const LightTree& tree, std::span<const LocalLight> lights)
      : tree_(&tree), leaf_of_light_(lights.size()), sums_(2 * std::size_t(tree.leaf_count())) {
    frame_.nodes.resize(sums_.size());
    emissions_.resize(sums_.size());
    for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf)
      if (tree.light_of_leaf[leaf] != no_light) leaf_of_light_[tree.light_of_leaf[leaf]] = leaf;
    for (std::uint32_t leaf = 0; leaf < tree.leaf_count(); ++leaf)
      set_leaf(leaf, tree.light_of_leaf[leaf] == no_light ? LocalLight{} : lights[tree.light_of_leaf[leaf]]);
    for (std::uint32_t h = tree.leaf_count(); h-- > 1;) join(h);
  }

  /// Gives the lights `changed` (indices, each once) new values and refits the nodes above them: the same
  /// bits as those of a new LocalLighting over all lights. The illumination cut stays as it was; set_cut
  /// chooses anew.
  void update(std::span<const std::uint32_t> changed, std::span<const LocalLight> values) {
    COPPICE_ASSERT(changed.size() == values.size());
    leaves_.clear();
    for (std::size_t i = 0; i < changed.size(); ++i) {
      leaves_.push_back(leaf_of_light_[changed[i]]);
      set_leaf(leaves_.back(), values[i]);
    }
    refit(tree_->leaf_count(), leaves_, scratch_, [this](std::uint32_t h) { join(h); });
  }

  /// The illumination cut: the node of greatest luminance is split first, up to max_nodes (Cuts section 3.2).
  void set_cut(std::size_t max_nodes, std::uint32_t granule_log2) {
    const auto intensity = [&](std::uint32_t h) { return double(emissions_[h].luminance); };
    const std::uint32_t n = tree_->leaf_count();
    set_illumination_cut(frame_, n, select_by_budget(n, intensity, max_nodes), granule_log2);
  }

  const LightTree& tree() const { return *tree_; }
  const LocalFrameLighting& frame() const { return frame_; }
  std::span<const LocalEmission> emissions() const { return emissions_; }  ///< by heap id

 private:
  void set_leaf(std::uint32_t leaf, const LocalLight& light) {
    const std::uint32_t h = tree_->leaf_count() + leaf;
    sums_[h] = detail::LocalLightSum::of(light);
    write_node(h);
  }
  void join(std::uint32_t h) {
    sums_[h] = sums_[2 * h] + sums_[2 * h + 1];
    write_node(h);
  }
  void write_node(std::uint32_t h) {
    const detail::LocalLightSum& s = sums_[h];
    frame_.nodes[h] = {vec3(s.power), float(s.variance), vec3(s.position), float(s.w)};
    emissions_[h] = {
        vec3(s.axis),      float(s.offset), float(s.square), float(s.softening), radius(s, vec3(s.position)),
        float(s.luminance)};
  }
  /// Of a ball around the rounded mean position.
  static float radius(const detail::LocalLightSum& s, const vec3& centre) {
    const double exact = s.radius + glm::length(glm::dvec3(centre) - s.position);
    return exact > 0 ? std::nextafter(float(exact * (1 + 1e-12)), std::numeric_limits<float>::infinity())
                     : 0.0f;
  }

  const LightTree* tree_ = nullptr;
  std::vector<std::uint32_t> leaf_of_light_;
  std::vector<detail::LocalLightSum> sums_;
  LocalFrameLighting frame_;
  std::vector<LocalEmission> emissions_;
  std::vector<std::uint32_t> leaves_, scratch_;
};

}  // namespace coppice
