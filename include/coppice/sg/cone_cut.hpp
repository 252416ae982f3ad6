// Cones placed by a cut of light × BRDF: a point's light as a few Gaussians, each to be traced as one cone.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <array>
#include <bit>
#include <coppice/relight/shade.hpp>
#include <coppice/sg/lit_cones.hpp>
#include <coppice/sg/product_tree.hpp>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

struct ConeCutOptions {
  /// Cones at most for what is not a peak; each peak that matters has one more.
  std::uint32_t cones = 7;
  /// LobeOptions::tolerance of the light × BRDF.
  float lobe_tolerance = 1e-3f;
  /// Cones that give less than this share of the point's light are not traced: as much of them is taken to be
  /// visible as of the others.
  float negligible = 2e-3f;
};

/// Cones placed by a cut of light × BRDF: multiplies the lights with a point's BRDF at the pieces of the
/// illumination cut, and finer where the lobe is narrower than a piece; sums the products up the tree, with
/// their mean direction; and splits from the root on the node of the most light and spread. What stays whole
/// becomes a Gaussian of the same mean direction and spread as its light × BRDF, which the visibility of the
/// node is that of. Keeps its scratch between points.
class ConeCut {
 public:
  explicit ConeCut(const ProductTree& tree, const ConeCutOptions& options = {})
      : tree_(tree), options_(options), sums_(tree.clusters().size() + tree.joints().size()) {}

  /// Directions are those of the tree's lights. The result is good until the next call.
  const LitCones& place(const ShadingPoint& point) {
    with_brdf(point, [&](const auto& brdf) { evaluate(point, brdf); });
    join();
    result_.cones.clear();
    result_.untraced = vec3(0);
    least_ = options_.negligible * total_luminance();
    split();
    close_peaks();
    return result_;
  }

  /// The same with all that is no peak's in `untraced`, for who places other cones for it.
  const LitCones& place_peaks(const ShadingPoint& point) {
    with_brdf(point, [&](const auto& brdf) { evaluate(point, brdf); });
    join();
    result_.cones.clear();
    result_.untraced = root_sum().radiance;
    least_ = 0;
    close_peaks();
    return result_;
  }

 private:
  /// What a node adds: radiance, its luminance, and luminance times direction.
  struct Sum {
    vec3 radiance{0};
    float luminance = 0;
    vec3 moment{0};
    float spread() const {
      return luminance > 0 ? std::clamp(1 - length(moment / luminance), 0.0f, 1.0f) : 0.0f;
    }
    friend Sum operator+(const Sum& a, const Sum& b) {
      return {a.radiance + b.radiance, a.luminance + b.luminance, a.moment + b.moment};
    }
  };
  struct Queued {
    std::uint32_t node, piece;
  };
  struct Open {
    float priority;
    std::uint32_t node;
    friend bool operator<(const Open& a, const Open& b) {
      return a.priority < b.priority || (a.priority == b.priority && a.node > b.node);
    }
  };
  /// A register of clusters after the BRDF.
  struct Products {
    Lanes red, green, blue, luminance, error;
  };

  template <class B>
  static HWY_INLINE Products multiply(const ShadingPoint& p, const B& brdf, const LocalFrame& frame, Lanes x,
                                      Lanes y, Lanes z, const LightSpread<Lanes>& spread, Lanes red,
                                      Lanes green, Lanes blue) {
    const auto t =
        brdf.filtered(LocalFrame::along(frame.tangent, x, y, z), LocalFrame::along(frame.bitangent, x, y, z),
                      LocalFrame::along(frame.normal, x, y, z), spread);
    const auto lobe = [&](int k) {
      return mul_add(Lanes(p.specular[k]), t.specular, Lanes(p.fresnel[k]) * t.fresnel);
    };
    const Lanes lobes[3] = {lobe(0), lobe(1), lobe(2)};
    const auto luminance = [](Lanes r, Lanes g, Lanes b) {
      return mul_add(Lanes(0.2126f), r, mul_add(Lanes(0.7152f), g, Lanes(0.0722f) * b));
    };
    Products q;
    q.red = red * mul_add(Lanes(p.diffuse.x), t.diffuse, lobes[0]);
    q.green = green * mul_add(Lanes(p.diffuse.y), t.diffuse, lobes[1]);
    q.blue = blue * mul_add(Lanes(p.diffuse.z), t.diffuse, lobes[2]);
    q.luminance = luminance(q.red, q.green, q.blue);
    q.error = t.growth * luminance(red * lobes[0], green * lobes[1], blue * lobes[2]);
    return q;
  }

  template <class B>
  HWY_INLINE void evaluate(const ShadingPoint& point, const B& brdf) {
    const LocalFrame frame(point);
    const ClusterList& c = tree_.clusters();
    errors_.resize(c.padded_size());
    Lanes total = 0.0f;
    for (std::size_t i = 0; i < c.size(); i += Lanes::width) {
      const auto load = [&](ClusterList::Field f) { return Lanes::load(c.field(f) + i); };
      const Lanes x = load(ClusterList::x), y = load(ClusterList::y), z = load(ClusterList::z);
      const LightSpread<Lanes> spread{load(ClusterList::mean_length), load(ClusterList::widening)};
      const Products q = multiply(point, brdf, frame, x, y, z, spread, load(ClusterList::red),
                                  load(ClusterList::green), load(ClusterList::blue));
      q.error.store(&errors_[i]);
      total += q.luminance;
      store(q, x, y, z, spread.mean_length, i, std::min(Lanes::width, c.size() - i));
    }
    result_.clusters = std::uint32_t(c.size());
    refine(point, brdf, frame, options_.lobe_tolerance * sum_of_lanes(total));
  }

  /// Writes the sums of clusters i … i + count - 1.
  HWY_INLINE void store(const Products& q, Lanes x, Lanes y, Lanes z, Lanes length, std::size_t i,
                        std::size_t count) {
    const Lanes along = q.luminance * length;
    const std::array<Lanes, 7> fields{q.red, q.green, q.blue, q.luminance, along * x, along * y, along * z};
    alignas(64) std::array<std::array<float, Lanes::width>, 7> v;
    for (std::size_t f = 0; f < 7; ++f) fields[f].store(v[f].data());
    for (std::size_t k = 0; k < count; ++k)
      sums_[i + k] = {{v[0][k], v[1][k], v[2][k]}, v[3][k], {v[4][k], v[5][k], v[6][k]}};
  }

  /// Replaces the pieces over which the lobe changes too much by their descendants' sums.
  template <class B>
  HWY_INLINE void refine(const ShadingPoint& point, const B& brdf, const LocalFrame& frame, float limit) {
    if (B::terms == 1) return;
    queue_.clear();
    for (std::uint32_t i = 0; i < tree_.piece_count(); ++i)
      if (errors_[i] > limit) split_piece(tree_.clusters().nodes()[i], i, sums_[i]);
    for (std::size_t i = 0; i < queue_.size();) i += descend(point, brdf, frame, limit, i);
    result_.clusters += std::uint32_t(queue_.size());
  }

  void split_piece(std::uint32_t node, std::uint32_t piece, Sum& sum) {
    if (2 * node >= tree_.nodes().size()) return;
    sum = Sum{};
    push_children(node, piece);
  }

  void push_children(std::uint32_t node, std::uint32_t piece) {
    queue_.push_back({2 * node, piece}), queue_.push_back({2 * node + 1, piece});
  }

  /// A register of the queue from element i on. Returns how many elements it took.
  template <class B>
  HWY_INLINE std::size_t descend(const ShadingPoint& point, const B& brdf, const LocalFrame& frame,
                                 float limit, std::size_t i) {
    const std::size_t count = std::min(Lanes::width, queue_.size() - i);
    std::array<LightNode, Lanes::width> nodes{};
    for (std::size_t k = 0; k < count; ++k) nodes[k] = tree_.nodes()[queue_[i + k].node];
    const NodeLanes n = load_nodes(nodes.data());
    const LightSpread<Lanes> spread = light_spread(n.spread);
    const Products q = multiply(point, brdf, frame, n.x, n.y, n.z, spread, n.red, n.green, n.blue);
    alignas(64) std::array<std::array<float, Lanes::width>, 5> v;
    q.red.store(v[0].data()), q.green.store(v[1].data()), q.blue.store(v[2].data());
    q.luminance.store(v[3].data()), q.error.store(v[4].data());
    for (std::size_t k = 0; k < count; ++k) {
      const Queued at = queue_[i + k];
      if (v[4][k] > limit && 2 * at.node < tree_.nodes().size())
        push_children(at.node, at.piece);
      else
        sums_[at.piece] =
            sums_[at.piece] +
            Sum{{v[0][k], v[1][k], v[2][k]}, v[3][k], v[3][k] * (1 - nodes[k].spread) * nodes[k].direction};
    }
    return count;
  }

  void join() {
    Sum* joint = sums_.data() + tree_.clusters().size();
    const auto at = [&](std::uint32_t node) -> const Sum& { return sums_[index(node)]; };
    for (const uvec2& children : tree_.joints()) *joint++ = at(children.x) + at(children.y);
  }

  /// Of a node's sum: peaks lie between pieces and joints.
  std::size_t index(std::uint32_t node) const {
    return node < tree_.piece_count() ? node : node + tree_.peak_count();
  }

  /// Of all that is no peak's.
  Sum root_sum() const { return tree_.piece_count() > 0 ? sums_[index(tree_.root())] : Sum{}; }

  float total_luminance() const {
    float total = root_sum().luminance;
    for (std::uint32_t i = tree_.piece_count(); i < tree_.clusters().size(); ++i) total += sums_[i].luminance;
    return total;
  }

  /// From the root on, the node of the most light and spread first.
  void split() {
    open_.clear();
    if (tree_.piece_count() > 0) open(tree_.root());
    std::uint32_t closed = 0;
    while (!open_.empty() && open_.size() + closed < options_.cones) {
      std::pop_heap(open_.begin(), open_.end());
      const std::uint32_t node = open_.back().node;
      open_.pop_back();
      if (node < tree_.piece_count()) {
        close(sums_[node]), ++closed;
        continue;
      }
      const uvec2 children = tree_.joints()[node - tree_.piece_count()];
      open(children.x), open(children.y);
    }
    for (const Open& o : open_) close(sums_[index(o.node)]);
  }

  void close_peaks() {
    for (std::uint32_t i = 0; i < tree_.peak_count(); ++i)
      if (const Sum& s = sums_[tree_.piece_count() + i]; s.luminance > 0) close(s, tree_.peaks()[i]);
  }

  /// Nodes that reflect nothing take no cone.
  void open(std::uint32_t node) {
    const Sum& s = sums_[index(node)];
    if (!(s.luminance > 0)) return;
    const float spread = std::max(s.spread() - 1e-6f, 0.0f);  // what rounding makes of one direction is none
    open_.push_back({s.luminance * std::sqrt(std::sqrt(spread)), node});
    std::push_heap(open_.begin(), open_.end());
  }

  void close(const Sum& s) { close(s, sg_from_moments(s.moment / std::max(s.luminance, 1e-37f))); }

  void close(const Sum& s, const SgShape& shape) {
    if (s.luminance > least_)
      result_.cones.push_back({shape, s.radiance, s.luminance});
    else
      result_.untraced += s.radiance;
  }

  const ProductTree& tree_;
  ConeCutOptions options_;
  std::vector<Sum> sums_;  ///< pieces, peaks, joints
  std::vector<float> errors_;
  std::vector<Queued> queue_;
  std::vector<Open> open_;
  float least_ = 0;  ///< luminance below which a node has no cone
  LitCones result_;
};

}  // namespace coppice::inline HWY_NAMESPACE
