#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <coppice/core/error.hpp>
#include <coppice/light/bounce.hpp>
#include <coppice/light/scene_lights.hpp>
#include <coppice/relight/local_relighting.hpp>
#include <coppice/store/store.hpp>
#include <numeric>
#include <support/paper_scene.hpp>
#include <support/report.hpp>

namespace coppice::program {
namespace {

constexpr std::size_t measured_stride = 8;  // every how manieth receiver counts for the RMS

std::vector<std::uint32_t> all_of(std::span<const Receiver> receivers) {
  std::vector<std::uint32_t> all(receivers.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

template <Quantised Value>
double mean_pieces(const MaskedCuts<Value>& cuts) {
  return double(cuts.values().size()) / double(std::max<std::size_t>(1, cuts.size()));
}

/// What a store of it takes on the disk.
template <Quantised Value>
std::size_t stored_bytes(const StoredVisibility<Value>& visibility) {
  namespace fs = std::filesystem;
  const fs::path path = fs::temp_directory_path() / ("coppice_trade_" + std::to_string(::getpid()) + ".h5");
  write_store(path, visibility);
  const std::size_t bytes = fs::file_size(path);
  fs::remove(path);
  return bytes;
}

/// Of points, all alike.
double rel_rmse(std::vector<vec3> radiance, const std::vector<vec3>& reference) {
  Image image(int(radiance.size()), 1), other = image;
  image.pixels = std::move(radiance), other.pixels = reference;
  return image_errors(image, other, std::vector<bool>(reference.size(), true)).rel_rmse;
}

/// Milliseconds that the calling thread has run: what else the machine does counts little.
double thread_milliseconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * double(time.tv_sec) + 1e-6 * double(time.tv_nsec);
}

/// Frames of each size in turn. render(nodes) gives the radiance of every point, on the calling thread.
template <class Render>
std::vector<PaperFrame> measure_frames(const PaperRequest& request, const std::vector<vec3>& reference,
                                       const Render& render) {
  std::vector<PaperFrame> frames;
  for (const std::size_t nodes : request.nodes) frames.push_back({nodes});
  for (int round = 0; round < request.repeat; ++round)
    for (PaperFrame& f : frames) {
      const double start = thread_milliseconds();
      std::vector<vec3> radiance = render(f.nodes);
      f.milliseconds.push_back(thread_milliseconds() - start);
      if (round == 0) f.rel_rmse = rel_rmse(std::move(radiance), reference);
    }
  return frames;
}

class EnvironmentScene : public PaperScene {
 public:
  EnvironmentScene(const SystemOptions& options, Inputs& in, const EmbreeTracer& tracer,
                   const Threads& threads)
      : PaperScene(options, in, tracer, threads),
        base_(in.scene, tracer, in.camera, in.environment, settings(), threads, visibility_progress()) {
    base_.use(kernels_of(options.cut));
    tree_ = base_.tree();
    rows_ = VisibilityRows(tree_.leaf_count(), all_of(base_.receivers()));
    for (std::size_t i = 0; i < rows_.size(); ++i)
      std::ranges::copy(base_.bits().subspan(i * rows_[i].size(), rows_[i].size()), rows_[i].begin());
    reference_ = base_.shade_by_brute_force<Skip::unseen>(reference_lighting(), threads);
    const PreparationReport& r = base_.report();
    tree_seconds_ = r.tree, receiver_seconds_ = r.camera + r.refinement, ray_seconds_ = r.visibility;
    count(base_.directions().size());
  }

  PaperCuts measure(const PaperRequest& request) override {
    const VisibilityCutOptions options = visibility_options(options_.cut, request.sigma, request.way.cuts);
    const DirectionPackets lights(leaf_directions(tree_, base_.directions()));
    Stopwatch watch;
    auto made = precompute_visibility<std::uint8_t>(tracer_, tree_, lights, base_.receivers(),
                                                    std::span(&options, 1), false, threads_, {}, rows_);
    MaskedCuts<std::uint8_t>& cuts = made.cuts[0];
    PaperCuts result{request.sigma, mean_pieces(cuts), 0, watch.lap(), cuts.byte_count()};
    result.rms = root_mean([&](std::size_t r) {
      return squares_of(cuts.unpack(r), rows_[r], lights, horizon_of(base_.receivers()[r], options.weight));
    });
    if (!request.nodes.empty()) measure_images(request, std::move(cuts), result);
    return result;
  }

 private:
  std::vector<LightSample> light_samples() const override {
    std::vector<LightSample> samples;
    for (const vec3& d : base_.directions()) samples.push_back({d, vec3(0)});
    return samples;
  }
  const PreparedView& view() const override { return base_.view(); }

  /// No cuts: they are selected later, from the rows that are kept.
  CutRelightingOptions settings() const {
    CutRelightingOptions o = relighting_options(options_.common, options_.cut);
    o.beta = 1;
    o.cuts.clear();
    o.keep_bits = true;
    return o;
  }

  FrameLighting reference_lighting() const {
    const EnvironmentCells cells(even_directions(options_.cut.lights, options_.common.seed),
                                 in_.environment.map.width, in_.environment.map.height);
    return light_frame(tree_, cells.gather(in_.environment), base_.directions(), 1, 0);
  }

  static Sums squares_of(const Cut<std::uint8_t>& cut, std::span<const std::uint64_t> row,
                         const DirectionPackets& lights, const ReceiverHorizon& horizon) {
    Sums sum;
    for_each_piece(cut.ends, [&](LeafRange r, std::size_t piece) {
      const float value = float(cut.values[piece]) / float(quantised_one<std::uint8_t>);
      for (std::uint32_t leaf = r.begin; leaf < r.end; ++leaf) {
        const vec3 d = lights.direction(leaf);
        if (d == vec3(0)) continue;  // padding
        const float above = (dot(horizon.normal, d) - horizon.cosine) / (1 - horizon.cosine);
        const double weight = double(std::max(0.0f, above));
        const double difference = (bit_at(row.data(), leaf) ? 1.0 : 0.0) - double(value);
        sum.weight += weight;
        sum.squares += weight * difference * difference;
      }
    });
    return sum;
  }

  StoredVisibility<std::uint8_t> content(const PaperWay& way, MaskedCuts<std::uint8_t> cuts) const {
    StoredVisibility<std::uint8_t> content;
    content.tree = tree_;
    content.mesh = view().mesh;
    content.receivers = view().receivers;
    content.weight = way.cuts.weight;
    for (const vec3& d : base_.directions()) content.lights.emplace_back(d, 0.0f);
    content.cuts = std::move(cuts);
    return content;
  }

  void measure_images(const PaperRequest& request, MaskedCuts<std::uint8_t> cuts, PaperCuts& result) const {
    auto stored = content(request.way, std::move(cuts));
    result.file_bytes = stored_bytes(stored);
    CutRelighting<> relighting(in_.scene, tracer_, in_.camera, std::move(stored.tree), light_directions(),
                               ViewReceivers{std::move(stored.mesh), view().receivers},
                               std::move(stored.cuts), settings(), threads_);
    relighting.use(base_.kernels());
    relighting.light(in_.environment, 1);  // assigns the map to the lights, which is no part of a frame
    const auto render = [&](std::size_t nodes) {
      const FrameLighting frame = relighting.light(in_.environment, nodes);
      return relighting.shade(frame, Serial{}, 0, {}, {request.way.lobes, options_.cut.lobe_tolerance});
    };
    result.frames = measure_frames(request, reference_, render);
  }

  std::vector<vec3> light_directions() const {
    return {base_.directions().begin(), base_.directions().end()};
  }

  CutRelighting<> base_;
  std::vector<vec3> reference_;  // by point, from all lights
};

class LocalScene : public PaperScene {
 public:
  LocalScene(const SystemOptions& options, Inputs& in, const EmbreeTracer& tracer, const Threads& threads)
      : PaperScene(options, in, tracer, threads) {
    gather_lights();
    Stopwatch watch;
    tree_ = build_local_tree(lights_);
    tree_seconds_ = watch.lap();
    trace();
    ray_seconds_ = watch.lap();
    reference_ = shade_all_lights();
    count(lights_.size());
  }

  PaperCuts measure(const PaperRequest& request) override {
    const LocalLightPackets packets(leaf_lights(tree_, lights_));
    Stopwatch watch;
    LocalCuts cuts = select(visibility_options(options_.cut, request.sigma, request.way.cuts));
    PaperCuts result{request.sigma, mean_pieces(cuts.cuts), 0, watch.lap(),
                     cuts.cuts.byte_count() + 4 * cuts.scales.size()};
    result.rms = root_mean([&](std::size_t r) {
      return squares_of(cuts.cuts.unpack(r), cuts.scales[r], rows_[r], packets, view_.receivers[r]);
    });
    if (!request.nodes.empty()) measure_images(request, std::move(cuts), result);
    return result;
  }

 private:
  std::vector<LightSample> light_samples() const override { return metric_samples(lights_); }
  const PreparedView& view() const override { return view_; }

  /// Receivers are refined for the direct light, as in cut_relighting.
  void gather_lights() {
    const std::string file = options_.common.scene.string();
    lights_ = scene_lights(in_.scene, options_.emitters, options_.common.seed);
    if (lights_.empty()) throw InputError(file, "has no lights and no shining surfaces", "use --lights env");
    const LightTree tree = build_local_tree(lights_);
    view_ = prepare_view(in_.scene, tracer_, in_.camera, relighting_options(options_.common, options_.cut),
                         pilot_lights(tree, lights_, 2048), pilot_lights(tree, lights_, 256), threads_);
    receiver_seconds_ = view_.camera_seconds + view_.refinement_seconds;
    if (options_.lights == LightKind::indirect) lights_ = bounce_lights(lights_);
    if (lights_.empty()) throw InputError(file, "has no surface that its lights reach", "use --lights scene");
  }

  std::vector<LocalLight> bounce_lights(std::span<const LocalLight> direct) const {
    const auto samples = bounce_samples(in_.scene, direct, tracer_, threads_,
                                        {options_.bounces, options_.common.seed, options_.common.shading});
    std::vector<LocalLight> lights(samples.size());
    coppice::light_samples(samples, direct, tracer_, threads_, lights);
    return lights;
  }

  LocalCuts select(const VisibilityCutOptions& options) const {
    return precompute_local_cuts(tracer_, tree_, LocalLightPackets(leaf_lights(tree_, lights_)),
                                 view_.receivers, options, threads_, {}, rows_);
  }

  void trace() {
    const LocalLightPackets packets(leaf_lights(tree_, lights_));
    rows_ = VisibilityRows(tree_.leaf_count(), all_of(view_.receivers));
    threads_(rows_.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        trace_visibility(tracer_, packets, view_.receivers[i], rows_[i]);
    });
  }

  /// V·G as finely as cuts can hold it (docs/trade.md), every light by itself.
  std::vector<vec3> shade_all_lights() const {
    const VisibilityCutOptions finest{0, std::size_t{1} << 16, CutWeight::uniform, CutSearch::threshold};
    LocalRelighting relighting(view_, lights_, tree_, select(finest), {{}, {Lobes::sampled}, 1, {}});
    relighting.use(local_kernels_of(options_.cut));
    relighting.set_cut(tree_.leaf_count());
    return relighting.shade(threads_);
  }

  /// Relative to the squares of V·G, so that each receiver counts alike.
  Sums squares_of(const Cut<std::uint16_t>& cut, float scale, std::span<const std::uint64_t> row,
                  const LocalLightPackets& lights, const Receiver& receiver) const {
    double all = 0, wrong = 0;
    for_each_piece(cut.ends, [&](LeafRange r, std::size_t piece) {
      const double root = cut.values[piece], value = root * root * double(scale);
      for (std::uint32_t leaf = r.begin; leaf < r.end; ++leaf) {
        if (tree_.light_of_leaf[leaf] == no_light) continue;
        const double g = bit_at(row.data(), leaf) ? double(lights.geometry(leaf, receiver.position)) : 0;
        all += g * g, wrong += (g - value) * (g - value);
      }
    });
    return all > 0 ? Sums{1, wrong / all} : Sums{};
  }

  std::size_t file_bytes(const LocalCuts& cuts) const {
    StoredVisibility<std::uint16_t> content;
    content.tree = tree_;
    content.mesh = view_.mesh;
    content.receivers = view_.receivers;
    content.weight = CutWeight::uniform;
    for (const LocalLight& l : lights_) content.lights.emplace_back(l.position, l.w);
    content.cuts = cuts.cuts;
    content.scales = cuts.scales;
    return stored_bytes(content);
  }

  /// A frame in which the intensity of every light may have changed.
  void measure_images(const PaperRequest& request, LocalCuts cuts, PaperCuts& result) const {
    result.file_bytes = file_bytes(cuts);
    const LobeOptions lobes{request.way.lobes, options_.cut.lobe_tolerance};
    LocalRelighting relighting(view_, lights_, tree_, std::move(cuts), {{}, lobes, 1, {}});
    relighting.use(local_kernels_of(options_.cut));
    std::vector<std::uint32_t> every(lights_.size());
    std::iota(every.begin(), every.end(), 0u);
    const auto render = [&](std::size_t nodes) {
      relighting.lighting().update(every, lights_);
      relighting.set_cut(nodes);
      return relighting.shade(Serial{});
    };
    result.frames = measure_frames(request, reference_, render);
  }

  std::vector<LocalLight> lights_;
  PreparedView view_;
  std::vector<vec3> reference_;  // by point, from all lights
};

}  // namespace

void PaperScene::count(std::size_t lights) {
  counts_ = {in_.scene.mesh.triangles.size(), view().receivers.size(), view().buffer.points.size(), lights};
}

void PaperScene::drive_tree_by_data(float beta) {
  Stopwatch watch;
  PilotVisibility pilot{choose_pilots(view().receivers, {}), {}, 0};
  pilot.rows = VisibilityRows(tree_.leaf_count(), pilot.pilots.receivers);
  for (std::size_t i = 0; i < pilot.rows.size(); ++i)
    std::ranges::copy(rows_[pilot.pilots.receivers[i]], pilot.rows[i].begin());
  LightTree driven = build_data_driven_tree(light_samples(), tree_, pilot, beta, {}, threads_);
  tree_seconds_ += watch.lap();
  reorder(rows_, tree_, driven, threads_);
  tree_ = std::move(driven);
}

double PaperScene::root_mean(const std::function<Sums(std::size_t)>& sums) const {
  std::vector<Sums> each((rows_.size() + measured_stride - 1) / measured_stride);
  threads_(each.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) each[i] = sums(i * measured_stride);
  });
  Sums all;
  for (const Sums& s : each) all.weight += s.weight, all.squares += s.squares;
  return all.weight > 0 ? std::sqrt(all.squares / all.weight) : 0;
}

std::unique_ptr<PaperScene> make_paper_scene(const SystemOptions& options, Inputs& in,
                                             const EmbreeTracer& tracer, const Threads& threads) {
  if (options.lights == LightKind::environment)
    return std::make_unique<EnvironmentScene>(options, in, tracer, threads);
  return std::make_unique<LocalScene>(options, in, tracer, threads);
}

}  // namespace coppice::program
