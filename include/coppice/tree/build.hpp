// Builds the light tree top down: two centres a cluster, lights sorted by the difference of their distances
// to them, cut in the middle (Cuts section 3.4).
#pragma once

#include <algorithm>
#include <array>
#include <coppice/tree/light_tree.hpp>
#include <coppice/tree/metric.hpp>
#include <numeric>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace coppice {

struct TreeOptions {
  int iterations = 8;  ///< rounds of moving the two centres before the cut; more gain nothing measurable
  std::size_t starts =
      1;  ///< first guesses in large clusters: orders along so many of the widest coordinates
};

/// Clusters of fewer lights make do with one first guess.
inline constexpr std::size_t several_starts_from = 512;

namespace detail {

/// Zeros, one a coordinate: on the stack where the metric's dimension is a constant.
template <class Number, LightMetric Metric>
auto coordinates_of(const Metric& metric) {
  if constexpr (requires { std::integral_constant<std::size_t, Metric::dimension()>(); })
    return std::array<Number, Metric::dimension()>{};
  else
    return std::vector<Number>(metric.dimension());
}

/// Recursive bisection. Positions are kept in the metric's Euclidean space, in which Eq. 11 is |s - c|², so
/// that d(s, c1) - d(s, c2) is linear in s: the order depends only on the projection on c2 - c1.
template <LightMetric Metric>
class TreeBuilder {
 public:
  TreeBuilder(const Metric& metric, TreeOptions options)
      : metric_(metric),
        options_(options),
        coordinates_(metric.size() * metric.dimension()),
        keys_(metric.size()) {
    for (std::uint32_t i = 0; i < metric.size(); ++i)
      metric.write_point(i, std::span(coordinates_).subspan(i * dimension(), dimension()));
  }

  /// Puts `lights` into the leaves below heap id h of `tree`.
  void place(LightTree& tree, std::uint32_t h, std::span<std::uint32_t> lights) {
    tree.light_count[h] = std::uint32_t(lights.size());
    const std::uint32_t n = tree.leaf_count();
    if (h >= n) {
      tree.light_of_leaf[h - n] = lights.empty() ? no_light : lights[0];
      return;
    }
    const std::size_t left = (lights.size() + 1) / 2;
    if (lights.size() > 1) split(lights, left);
    place(tree, 2 * h, lights.first(left));
    place(tree, 2 * h + 1, lights.subspan(left));
  }

 private:
  using Point = decltype(coordinates_of<float>(std::declval<const Metric&>()));

  /// A constant where the metric's is one, so that loops over few coordinates unroll.
  std::size_t dimension() const { return metric_.dimension(); }
  const float* point(std::uint32_t light) const { return coordinates_.data() + light * dimension(); }

  /// d(s, a) - d(s, b): that of the metric where it has one of its own, else |s - a|² - |s - b|². Many
  /// coordinates are added in lanes, few in order.
  float difference_of_distances(const float* s, const float* a, const float* b) const {
    if constexpr (requires { metric_.distance(s, a); })
      return metric_.distance(s, a) - metric_.distance(s, b);
    constexpr std::size_t lanes = 16;
    std::array<float, lanes> lane_sums{};
    std::size_t k = 0;
    for (; k + lanes <= dimension(); k += lanes)
      for (std::size_t i = 0; i < lanes; ++i)
        lane_sums[i] += (b[k + i] - a[k + i]) * (2 * s[k + i] - a[k + i] - b[k + i]);
    float sum = 0;
    if (k > 0) sum = std::accumulate(lane_sums.begin(), lane_sums.end(), 0.0f);
    for (; k < dimension(); ++k) sum += (b[k] - a[k]) * (2 * s[k] - a[k] - b[k]);
    return sum;
  }

  Point mean(std::span<const std::uint32_t> lights) const {
    auto sum = coordinates_of<double>(metric_);
    for (const auto i : lights) {
      const float* p = point(i);
      for (std::size_t k = 0; k < dimension(); ++k) sum[k] += double(p[k]);
    }
    Point m = coordinates_of<float>(metric_);
    for (std::size_t k = 0; k < dimension(); ++k) m[k] = float(sum[k] / double(lights.size()));
    return m;
  }

  /// Coordinates by how far the lights spread along them, as many as there are first guesses.
  std::vector<std::size_t> widest_axes(std::span<const std::uint32_t> lights) const {
    Point low = coordinates_of<float>(metric_);
    std::copy_n(point(lights[0]), dimension(), low.begin());
    Point high = low;
    for (const auto i : lights) {
      const float* p = point(i);
      for (std::size_t k = 0; k < dimension(); ++k)
        low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
    }
    const std::size_t starts = lights.size() < several_starts_from ? 1 : options_.starts;
    std::vector<std::size_t> axes(dimension());
    std::iota(axes.begin(), axes.end(), std::size_t{0});
    const auto chosen = axes.begin() + std::ptrdiff_t(std::min(starts, axes.size()));
    std::partial_sort(axes.begin(), chosen, axes.end(), [&](std::size_t a, std::size_t b) {
      const float size_a = high[a] - low[a], size_b = high[b] - low[b];
      return size_a > size_b || (size_a == size_b && a < b);
    });
    axes.erase(chosen, axes.end());
    return axes;
  }

  /// Ties are broken by the light's index, so that the order is total and the same everywhere.
  void order_by_key(std::span<std::uint32_t> lights, std::size_t left) {
    const auto before = [this](std::uint32_t a, std::uint32_t b) {
      return keys_[a] < keys_[b] || (keys_[a] == keys_[b] && a < b);
    };
    std::nth_element(lights.begin(), lights.begin() + std::ptrdiff_t(left), lights.end(), before);
  }

  /// The better of the splits from each first guess. As the halves are equal, the squared distances within
  /// them are least where their centres are farthest apart.
  void split(std::span<std::uint32_t> lights, std::size_t left) {
    const std::vector<std::size_t> axes = widest_axes(lights);
    if (axes.size() == 1) return split_from(axes[0], lights, left);
    std::vector<std::uint32_t> best;
    float best_distance = -1;
    for (const std::size_t axis : axes) {
      split_from(axis, lights, left);
      const float distance = squared_distance(mean(lights.first(left)), mean(lights.subspan(left)));
      if (distance <= best_distance) continue;
      best_distance = distance;
      best.assign(lights.begin(), lights.end());
    }
    std::ranges::copy(best, lights.begin());
  }

  static float squared_distance(const Point& a, const Point& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += double(a[k] - b[k]) * double(a[k] - b[k]);
    return float(sum);
  }

  /// The first guess is the order along an axis.
  void split_from(std::size_t axis, std::span<std::uint32_t> lights, std::size_t left) {
    for (const auto i : lights) keys_[i] = point(i)[axis];
    order_by_key(lights, left);
    for (int i = 0; i < options_.iterations; ++i) {
      const Point a = mean(lights.first(left)), b = mean(lights.subspan(left));
      if (a == b) return;
      for (const auto l : lights) keys_[l] = difference_of_distances(point(l), a.data(), b.data());
      order_by_key(lights, left);
    }
  }

  const Metric& metric_;
  TreeOptions options_;
  std::vector<float> coordinates_;  // dimension() a light
  std::vector<float> keys_;
};

}  // namespace detail

/// The light tree over metric.size() lights. Where their number is no power of two the padding is spread
/// evenly: the halves of a node differ by at most one light. Deterministic; O(n log n · iterations), about 40
/// ms for 32,768 lights a core. Precondition: the metric's points are finite.
template <LightMetric Metric>
LightTree build_tree(const Metric& metric, TreeOptions options = {}) {
  LightTree tree;
  const std::uint32_t n = leaf_count_for(metric.size());
  tree.light_of_leaf.assign(n, no_light);
  tree.light_count.assign(2 * std::size_t(n), 0);
  if (n == 0) return tree;
  std::vector<std::uint32_t> lights(metric.size());
  std::iota(lights.begin(), lights.end(), 0u);
  detail::TreeBuilder<Metric>(metric, options).place(tree, 1, lights);
  return tree;
}

}  // namespace coppice
