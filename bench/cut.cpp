// Selecting cuts, and merging them.
#include <coppice/cut/merge.hpp>
#include <coppice/reference/merge_face.hpp>
#include <coppice/reference/merge_postorder.hpp>

#include "check.hpp"
#include "demo.hpp"

namespace coppice::bench {
namespace {

using VisibilityCut = Cut<std::uint8_t>;

/// Receivers whose cuts are selected, in turn.
const std::vector<std::uint32_t>& chosen_receivers() {
  static const auto chosen = spread_indices(64, Demo::get().relighting.receivers().size());
  return chosen;
}

ReceiverHorizon horizon_at(std::uint32_t receiver, CutWeight weight) {
  return horizon_of(Demo::get().relighting.receivers()[receiver], weight);
}

/// The weight of a leaf at a receiver, by its definition.
double leaf_weight(std::uint32_t leaf, const ReceiverHorizon& horizon) {
  const auto& relighting = Demo::get().relighting;
  const std::uint32_t light = relighting.tree().light_of_leaf[leaf];
  if (light == no_light) return 0;
  if (horizon.normal == vec3(0)) return 1;
  const double cosine = glm::dot(glm::dvec3(horizon.normal), glm::dvec3(relighting.directions()[light]));
  return std::max(0.0, (cosine - horizon.cosine) / (1 - double(horizon.cosine)));
}

/// The slow twin of VisibilityCutSelector: the weights of every node, from all its leaves, in double
/// precision.
VisibilityCut select_by_moments(std::uint32_t receiver, const VisibilityCutOptions& options) {
  const Demo& demo = Demo::get();
  const std::uint32_t n = demo.relighting.tree().leaf_count(), log2 = granule_log2_for(options.sigma, n);
  const ReceiverHorizon horizon = horizon_at(receiver, options.weight);
  const auto bits = demo.bits(receiver);
  const auto weight = [&](std::uint32_t leaf) { return leaf_weight(leaf, horizon); };
  const auto seen = [&](std::uint32_t leaf) { return bit_at(bits.data(), leaf) ? weight(leaf) : 0.0; };
  const auto all = aggregate(n, weight, std::plus<>()), visible = aggregate(n, seen, std::plus<>());
  const auto mean = [&](std::uint32_t h) { return all[h] > 0 ? visible[h] / all[h] : 0.0; };
  const auto error = [&](std::uint32_t h) { return mean(h) * (all[h] - visible[h]); };
  const double sigma2 = options.sigma * options.sigma;
  auto cut =
      cut_with_values(n >> log2,
                      options.search == CutSearch::threshold
                          ? select_by_threshold(n >> log2, error, sigma2, options.max_size)
                          : select_optimal(n >> log2, error, price_of_piece(options.sigma), options.max_size),
                      [&](std::uint32_t h) { return quantise<std::uint8_t>(float(mean(h))); });
  for (std::uint32_t& end : cut.ends) end <<= log2;
  return cut;
}

/// Equal but for a level of the values, which rounding may decide.
bool alike(const VisibilityCut& a, const VisibilityCut& b) {
  const auto one_level = [](std::uint8_t x, std::uint8_t y) { return std::abs(int(x) - int(y)) <= 1; };
  return a.ends == b.ends && std::ranges::equal(a.values, b.values, one_level);
}

VisibilityCutSelector selector_for(const VisibilityCutOptions& options) {
  const auto& relighting = Demo::get().relighting;
  const DirectionPackets leaf_lights(leaf_directions(relighting.tree(), relighting.directions()));
  return {relighting.tree(), leaf_lights, options};
}

VisibilityCut select(VisibilityCutSelector& selector, std::uint32_t receiver, CutWeight weight) {
  return selector.select<std::uint8_t>(Demo::get().bits(receiver), horizon_at(receiver, weight));
}

/// Share of the chosen receivers whose cut is not the twin's.
double selection_error(const VisibilityCutOptions& options) {
  VisibilityCutSelector selector = selector_for(options);
  const auto wrong = std::ranges::count_if(chosen_receivers(), [&](std::uint32_t r) {
    return !alike(select(selector, r, options.weight), select_by_moments(r, options));
  });
  return double(wrong) / double(chosen_receivers().size());
}

/// Where two cuts cost nearly the same, rounding decides.
constexpr double near_ties = 0.05;

/// Selection at the chosen receivers, in turn; shows the mean number of pieces.
void select_visibility(benchmark::State& state, const VisibilityCutOptions& options) {
  if (!agrees(state, selection_error(options), near_ties)) return;
  VisibilityCutSelector selector = selector_for(options);
  std::size_t i = 0, pieces = 0;
  for (auto _ : state) {
    const auto cut = select(selector, chosen_receivers()[i++ % chosen_receivers().size()], options.weight);
    pieces += cut.size();
    benchmark::DoNotOptimize(cut.ends.data());
  }
  state.counters["pieces"] = double(pieces) / double(i);
}
const std::size_t cap = VisibilityCutOptions{}.max_size;
BENCHMARK_CAPTURE(select_visibility, 1, VisibilityCutOptions{1})
    ->Name("cut/select_visibility/sigma:1")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(select_visibility, 2, VisibilityCutOptions{2})
    ->Name("cut/select_visibility/sigma:2")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(select_visibility, 3, VisibilityCutOptions{3})
    ->Name("cut/select_visibility/sigma:3")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(select_visibility, cosine_threshold,
                  VisibilityCutOptions{2, cap, CutWeight::cosine, CutSearch::threshold})
    ->Name("cut/select_visibility/cosine_threshold/sigma:2")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(select_visibility, uniform_optimal,
                  VisibilityCutOptions{2, cap, CutWeight::uniform, CutSearch::optimal})
    ->Name("cut/select_visibility/uniform_optimal/sigma:2")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(select_visibility, uniform_threshold,
                  VisibilityCutOptions{2, cap, CutWeight::uniform, CutSearch::threshold})
    ->Name("cut/select_visibility/uniform_threshold/sigma:2")
    ->Unit(benchmark::kMicrosecond);

void select_visibility_by_moments(benchmark::State& state) {
  const VisibilityCutOptions& options = Demo::get().relighting.options().cuts[usual];
  if (!agrees(state, selection_error(options), near_ties)) return;
  std::size_t i = 0;
  for (auto _ : state)
    benchmark::DoNotOptimize(select_by_moments(chosen_receivers()[i++ % chosen_receivers().size()], options));
}
BENCHMARK(select_visibility_by_moments)
    ->Name("cut/select_visibility_by_moments/sigma:2")
    ->Unit(benchmark::kMicrosecond);

/// The popcount pyramid alone: where all is visible the cut is the root, and its selection costs nothing.
void count_visible(benchmark::State& state) {
  const VisibilityCutOptions options{2, cap, CutWeight::uniform, CutSearch::threshold};
  const std::vector<std::uint64_t> all(words_for_bits(Demo::get().relighting.tree().leaf_count()),
                                       ~std::uint64_t{0});
  VisibilityCutSelector selector = selector_for(options);
  const auto cut = selector.select<std::uint8_t>(all);
  const bool is_root = cut.size() == 1 && cut.values[0] == 255;
  if (!agrees(state, is_root ? 0 : 1, 0)) return;
  for (auto _ : state) benchmark::DoNotOptimize(selector.select<std::uint8_t>(all));
}
BENCHMARK(count_visible)->Name("cut/count_visible")->Unit(benchmark::kMicrosecond);

std::vector<float> sum_bits(std::uint32_t leaf_count, std::span<const std::uint64_t> bits) {
  return aggregate(
      leaf_count, [&](std::uint32_t leaf) { return float(bit_at(bits.data(), leaf)); }, std::plus<>());
}

/// The pyramid without popcounts: a float a leaf, added up.
void count_visible_by_floats(benchmark::State& state) {
  const Demo& demo = Demo::get();
  const std::uint32_t n = demo.relighting.tree().leaf_count(), receiver = chosen_receivers()[0];
  std::size_t count = 0;
  for (const std::uint64_t word : demo.bits(receiver)) count += std::size_t(std::popcount(word));
  if (!agrees(state, std::fabs(double(sum_bits(n, demo.bits(receiver))[1]) - double(count)), 0)) return;
  for (auto _ : state) benchmark::DoNotOptimize(sum_bits(n, demo.bits(receiver)));
}
BENCHMARK(count_visible_by_floats)->Name("cut/count_visible_by_floats")->Unit(benchmark::kMicrosecond);

/// The slow twin of select_by_budget: looks for the most intense node among all, each time.
template <class Intensity>
std::vector<std::uint32_t> select_by_scanning(std::uint32_t leaf_count, const Intensity& intensity,
                                              std::size_t size) {
  std::vector<std::uint32_t> nodes{1};
  const auto splittable = [&](std::uint32_t h) { return h < leaf_count ? intensity(h) : 0.0f; };
  while (nodes.size() < size) {
    const auto brightest = std::ranges::max_element(nodes, {}, splittable);
    if (splittable(*brightest) <= 0) break;
    *brightest *= 2;
    nodes.push_back(*brightest + 1);
  }
  std::vector<std::uint32_t> ends;
  for (const std::uint32_t h : nodes) ends.push_back(leaves_below(leaf_count, h).end);
  std::ranges::sort(ends);
  return ends;
}

void select_illumination(benchmark::State& state) {
  const Demo& demo = Demo::get();
  const std::uint32_t n = demo.relighting.tree().leaf_count();
  const auto intensity = [&](std::uint32_t h) { return luminance(demo.lighting[usual].nodes[h].power); };
  const auto select = [&] { return select_by_budget(n, intensity, illumination_nodes); };
  if (!agrees(state, select() == select_by_scanning(n, intensity, illumination_nodes) ? 0 : 1, 0)) return;
  for (auto _ : state) benchmark::DoNotOptimize(select());
}
BENCHMARK(select_illumination)->Name("cut/select_illumination/nodes:256")->Unit(benchmark::kMicrosecond);

/// The three visibility cuts of a face and the illumination cut, in the form that each way to merge them
/// wants.
struct FourCuts {
  uvec3 receivers;
  VisibilityCut a, b, c, illumination;
  std::vector<std::vector<reference::PostorderNode>> postorder;

  explicit FourCuts(const uvec3& corners) : receivers(corners) {
    const Demo& demo = Demo::get();
    const auto& cuts = demo.relighting.cuts(usual);
    a = cuts.unpack(corners.x), b = cuts.unpack(corners.y), c = cuts.unpack(corners.z);
    illumination.ends = demo.lighting[usual].ends;
    illumination.values.assign(illumination.ends.size(), 1);
    for (const VisibilityCut* cut : {&a, &b, &c, &illumination})
      postorder.push_back(reference::to_postorder(CutView<std::uint8_t>(*cut)));
  }

  std::size_t size() const { return a.size() + b.size() + c.size() + illumination.size(); }
};

const std::vector<FourCuts>& chosen_faces() {
  static const std::vector<FourCuts> chosen = [] {
    const auto& faces = Demo::get().relighting.buffer().faces;
    std::vector<FourCuts> four_cuts;
    for (const std::uint32_t f : spread_indices(64, faces.size())) four_cuts.emplace_back(faces[f].receivers);
    return four_cuts;
  }();
  return chosen;
}

/// Keeps the clusters that merge_face keeps: lit, and seen by a receiver.
void push_cluster(ClusterList& clusters, LeafRange leaves, float v0, float v1, float v2) {
  const Demo& demo = Demo::get();
  const std::uint32_t h = node_of_range(demo.relighting.tree().leaf_count(), leaves.begin, leaves.end);
  const LightNode& node = demo.lighting[usual].nodes[h];
  if ((v0 != 0 || v1 != 0 || v2 != 0) && node.power != vec3(0)) clusters.push(h, node, {v0, v1, v2});
}

struct Vectorised {
  FaceMerger<std::uint8_t> merger{Demo::get().relighting.cuts(usual), Demo::get().lighting[usual]};
  void operator()(const FourCuts& face, ClusterList& clusters) { merger.merge(face.receivers, clusters); }
};

struct ByMasks {
  void operator()(const FourCuts& face, ClusterList& clusters) const {
    const Demo& demo = Demo::get();
    reference::merge_face(demo.relighting.cuts(usual), face.receivers, demo.lighting[usual], clusters);
  }
};

struct ByEnds {
  void operator()(const FourCuts& face, ClusterList& clusters) const {
    clusters.reset(face.size());
    merge_cuts([&](LeafRange r, auto v0, auto v1, auto v2, auto) { push_cluster(clusters, r, v0, v1, v2); },
               face.a, face.b, face.c, face.illumination);
    clusters.pad();
  }
};

struct ByPostorder {
  void operator()(const FourCuts& face, ClusterList& clusters) const {
    clusters.reset(face.size());
    std::uint32_t begin = 0;
    reference::merge_postorder(face.postorder, [&](std::uint32_t leaves, auto nodes) {
      push_cluster(clusters, {begin, begin + leaves}, float(nodes[0].value), float(nodes[1].value),
                   float(nodes[2].value));
      begin += leaves;
    });
    clusters.pad();
  }
};

/// Clusters by node, as numbers: the vectorised merge has them in another order.
std::vector<std::vector<float>> sorted(const ClusterList& list) {
  std::vector<std::vector<float>> clusters;
  for (std::size_t i = 0; i < list.size(); ++i) {
    clusters.push_back({float(list.nodes()[i])});
    for (int f = 0; f < ClusterList::field_count; ++f)
      clusters.back().push_back(list.field(ClusterList::Field(f))[i]);
  }
  std::ranges::sort(clusters);
  return clusters;
}

/// Share of the chosen faces where the clusters are not those of the paper's merge.
template <class Merge>
double merge_error() {
  std::size_t wrong = 0;
  Merge merge;
  ClusterList fast, slow;
  for (const FourCuts& face : chosen_faces()) {
    merge(face, fast);
    ByPostorder()(face, slow);
    wrong += sorted(fast) != sorted(slow);
  }
  return double(wrong) / double(chosen_faces().size());
}

double mean_clusters() {
  double sum = 0;
  ClusterList clusters;
  for (const FourCuts& face : chosen_faces()) {
    ByMasks()(face, clusters);
    sum += double(clusters.size());
  }
  return sum / double(chosen_faces().size());
}

template <class Merge>
void merge(benchmark::State& state) {
  static const double error = merge_error<Merge>(), size = mean_clusters();
  if (!agrees(state, error, 0)) return;
  state.counters["clusters"] = size;
  state.counters["per_cluster"] = seconds_for_each(size);
  ClusterList clusters;
  Merge merge_once;
  std::size_t i = 0;
  for (auto _ : state) {
    merge_once(chosen_faces()[i++ % chosen_faces().size()], clusters);
    benchmark::DoNotOptimize(clusters.field(ClusterList::x));
  }
}
BENCHMARK(merge<Vectorised>)->Name("cut/merge/vectorised")->Unit(benchmark::kMicrosecond);
BENCHMARK(merge<ByMasks>)->Name("cut/merge/masks")->Unit(benchmark::kMicrosecond);
BENCHMARK(merge<ByEnds>)->Name("cut/merge/ends")->Unit(benchmark::kMicrosecond);
BENCHMARK(merge<ByPostorder>)->Name("cut/merge/postorder")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace coppice::bench
