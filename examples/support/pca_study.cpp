#include <support/pca_study.hpp>
//
#include <oneapi/tbb/global_control.h>

#include <coppice/core/error.hpp>
#include <coppice/core/stopwatch.hpp>
#include <coppice/transfer/free_space.hpp>
#include <support/pca_pictures.hpp>
#include <support/report.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

constexpr std::uint64_t unseen_seed = 0x77e57;  // other than those of the lights that rooms are made from

/// A light, and what rays and the solver say about it. Intensity 1.
struct JudgingLight {
  SizedLight light;
  std::vector<LocalLight> points;
  std::vector<float> visibility, direct;  ///< a sample
  std::vector<vec3> indirect;             ///< a sample
};

/// What the camera sees of a judging light.
struct ExactFrame {
  Image direct, indirect;
};

/// What one way of knowing shadows makes of the lights of frames.
struct ShadowFrames {
  std::string setting;
  std::size_t bytes = 0;
  std::vector<std::vector<float>> visibility;
  std::vector<Image> direct;
};

Image as_image(std::span<const vec3> values) {
  Image image(int(values.size()), 1);
  std::ranges::copy(values, image.pixels.begin());
  return image;
}

Image as_image(std::span<const float> values) {
  Image image(int(values.size()), 1);
  for (std::size_t i = 0; i < values.size(); ++i) image.pixels[i] = vec3(values[i]);
  return image;
}

Image sum(const Image& a, const Image& b) {
  Image result = a;
  for (std::size_t i = 0; i < result.pixels.size(); ++i) result.pixels[i] += b.pixels[i];
  return result;
}

/// Means over images. Those whose reference is black do not count.
class ErrorMean {
 public:
  void add(const Image& image, const Image& reference, const std::vector<bool>& counts) {
    if (std::ranges::all_of(reference.pixels, [](const vec3& p) { return p == vec3(0); })) return;
    const ImageErrors e = image_errors(image, reference, counts);
    sum_.rel_rmse += e.rel_rmse, sum_.mre += e.mre, ++images_;
  }
  void add(const Image& image, const Image& reference) {
    add(image, reference, std::vector<bool>(image.pixels.size(), true));
  }
  MeanErrors mean() const {
    const double n = double(std::max<std::size_t>(images_, 1));
    return {sum_.rel_rmse / n, sum_.mre / n};
  }

 private:
  MeanErrors sum_;
  std::size_t images_ = 0;
};

/// Collects stages light by light.
class StageTimes {
 public:
  void add(const Stages& stages) {
    for (const auto& [stage, ms] : stages) times_[stage].push_back(ms);
  }
  Stages medians() const {
    Stages result;
    for (const auto& [stage, all] : times_) result[stage] = median(all);
    return result;
  }

 private:
  std::map<std::string, std::vector<double>> times_;
};

double sum_of(const json& seconds) {
  double sum = 0;
  for (const auto& [stage, s] : seconds.items()) sum += s.get<double>();
  return sum;
}

/// One room with the lights that judge it.
class Judge {
 public:
  Judge(const PcaStudyOptions& o, const PcaRoomOptions& room, const Inputs& in, const EmbreeTracer& tracer,
        const Threads& threads)
      : o_(o),
        room_(room),
        in_(in),
        tracer_(tracer),
        threads_(threads),
        samples_(make_room_samples(room, in.scene, in.camera.position, tracer, threads, seconds_)) {}

  const std::vector<Flight>& flights() const { return samples_.field.flights; }
  bool is_empty() const { return samples().empty(); }

  void run(std::span<const vec3> lights, bool with_pictures, StudyResult& to) {
    prepare(lights);
    to.rooms.push_back({samples().size(), samples_.clustered.cluster_count(), sample_spacing(samples()),
                        solver_->transport.bytes(), seconds_});
    for (const VisibilitySetting& setting : o_.visibility) to.rows.push_back(judge(setting));
    for (const TransferSetting& setting : o_.transfer) judge(setting, with_pictures, to);
  }

 private:
  std::span<const SurfaceSample> samples() const { return samples_.clustered.samples; }

  StudyRow row_of(StudyKind kind, const std::string& setting) const {
    return {.kind = kind,
            .samples = samples().size(),
            .clusters = samples_.clustered.cluster_count(),
            .setting = setting};
  }

  void prepare(std::span<const vec3> lights) {
    Stopwatch watch;
    softening_ = softening_distance(samples());
    solver_.emplace(in_.scene, samples_.clustered, room_.transfer, tracer_, threads_);
    seconds_["transport"] = watch.lap();
    trial_.emplace(TrialRoom{samples_.clustered, *solver_, {}, {}, threads_});
    if (!o_.transfer.empty()) prepare_trials();
    watch.lap();
    for (const vec3& position : lights) light_exactly(position);
    solve_exactly();
    seconds_["exact_light"] = watch.lap();
    if (o_.frame_lights > 0 || !o_.pictures.empty()) prepare_view();
  }

  void prepare_trials() {
    Stopwatch watch;
    const auto positions = free_positions(flights(), room_.transfer.example_lights, room_.seed ^ 0x11947);
    trial_->examples = example_lights(samples(), positions, tracer_, threads_, softening_);
    seconds_["example_lights"] = watch.lap();
    if (std::ranges::none_of(o_.transfer, [](const TransferSetting& s) {
          return s.options.basis == LightBasisKind::transport_aware;
        }))
      return;
    TransportProbesOptions probes;
    probes.seed = room_.transfer.seed;
    trial_->probes = transport_probes(solver_->transport, solver_->albedos, threads_, probes);
    seconds_["probes"] = watch.lap();
  }

  void light_exactly(const vec3& position) {
    const SizedLight light{point_light(position, vec3(1)), o_.base.light_size};
    JudgingLight& judge = lights_.emplace_back(
        JudgingLight{light, points_of(light, o_.base.points), std::vector<float>(samples().size()), {}, {}});
    exact_visibility(samples(), judge.points, tracer_, threads_, judge.visibility);
    std::vector<vec3> direct(samples().size());
    light_directly(samples(), judge.points, tracer_, threads_, softening_, direct);
    for (const vec3& e : direct) judge.direct.push_back(e.x);
  }

  /// Several lights at a time.
  void solve_exactly() {
    constexpr std::size_t batch = 16;
    for (std::size_t begin = 0; begin < lights_.size(); begin += batch) {
      const std::size_t count = std::min(batch, lights_.size() - begin);
      Rows direct(samples().size(), 3 * count);
      for (std::size_t i = 0; i < samples().size(); ++i)
        for (std::size_t k = 0; k < 3 * count; ++k) direct[i][k] = lights_[begin + k / 3].direct[i];
      const Rows solved =
          interreflect(solver_->transport, solver_->albedos, direct, threads_, solver_->options);
      for (std::size_t l = 0; l < count; ++l)
        for (std::size_t i = 0; i < samples().size(); ++i)
          lights_[begin + l].indirect.emplace_back(solved[i][3 * l], solved[i][3 * l + 1],
                                                   solved[i][3 * l + 2]);
    }
  }

  void prepare_view() {
    Stopwatch watch;
    const PcaSystemOptions& b = o_.base;
    view_.emplace(in_.scene, tracer_, in_.camera, b.common.raster, b.common.shading, samples(), b.target,
                  b.splats, threads_);
    counts_ = counted_pixels(view_->seen());
    for (std::size_t l = 0; l < frame_lights(); ++l)
      frames_.push_back({view_->direct_by_rays(seen(l, {})), view_->indirect(lights_[l].indirect)});
    seconds_["exact_frames"] = watch.lap();
  }

  std::size_t frame_lights() const { return std::min(o_.frame_lights, lights_.size()); }
  std::vector<SeenLight> seen(std::size_t l, std::vector<float> visibility) const {
    return {{lights_[l].light, lights_[l].points, std::move(visibility)}};
  }

  std::vector<float> direct_of(std::size_t l, std::span<const float> visibility) const {
    std::vector<float> direct(samples().size());
    light_by_visibility(samples(), lights_[l].light.light, visibility, softening_, threads_, direct);
    return direct;
  }

  /// The lights' visibility, on one thread; medians of the times go to the row.
  std::vector<std::vector<float>> see_all(const RoomShadows& shadows, StudyRow& row) const {
    const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
    std::vector<std::vector<float>> all;
    StageTimes times;
    for (const JudgingLight& light : lights_) {
      Stopwatch watch;
      all.emplace_back(samples().size());
      shadows.see(light.light, o_.base.points, all.back());
      times.add({{"visibility", 1e3 * watch.lap()}});
    }
    row.milliseconds = times.medians();
    return all;
  }

  StudyRow judge(const VisibilitySetting& setting) {
    json seconds = json::object();
    const RoomShadowOptions& shadow = setting.options;
    const ClusteredSamples& clustered = samples_.clustered;
    const auto shadows = make_room_shadows(
        shadow, fit_room_visibility(shadow, clustered, flights(), tracer_, threads_, seconds), clustered,
        flights(), tracer_, threads_, seconds);
    StudyRow row = row_of(StudyKind::visibility, setting.text);
    row.bytes = shadows->bytes(), row.seconds = sum_of(seconds);
    std::vector<std::vector<float>> visibility = see_all(*shadows, row);
    DecisionCount decisions;
    ErrorMean errors;
    for (std::size_t l = 0; l < lights_.size(); ++l) {
      decisions.add(samples(), lights_[l].points, visibility[l], lights_[l].visibility);
      errors.add(as_image(direct_of(l, visibility[l])), as_image(lights_[l].direct));
    }
    row.decisions = decisions.result(), row.direct = errors.mean();
    ShadowFrames& frames = shadow_frames_.emplace_back(ShadowFrames{setting.text, row.bytes, {}, {}});
    for (std::size_t l = 0; l < frame_lights(); ++l) {
      frames.visibility.push_back(std::move(visibility[l]));
      frames.direct.push_back(view_->direct(samples(), seen(l, frames.visibility[l])));
    }
    return row;
  }

  void judge(const TransferSetting& setting, bool with_pictures, StudyResult& to) {
    const bool is_first = &setting == o_.transfer.data();
    Stopwatch watch;
    const SolvedBasis solved = solve_basis(setting, *trial_);
    const auto trial = make_trial(setting, solved, *trial_);
    StudyRow row = row_of(StudyKind::transfer, setting.text);
    row.bytes = trial->bytes(), row.seconds = watch.lap();
    measure(*trial, row);
    to.rows.push_back(row);
    if (is_first && with_pictures)
      write_pca_pictures(o_.pictures, *view_, samples_.clustered, solved.basis, solved.matrix);
    // Frames of all shadows with the first transfer, and of all transfers with the first shadows.
    for (std::size_t v = 0;
         v < (is_first ? shadow_frames_.size() : std::min<std::size_t>(1, shadow_frames_.size())); ++v)
      if (frame_lights() > 0) to.rows.push_back(judge_frames(shadow_frames_[v], row, *trial));
  }

  /// Indirect light of exact direct light.
  void measure(const TransferTrial& trial, StudyRow& row) const {
    ErrorMean errors;
    StageTimes times;
    std::vector<vec3> indirect(samples().size());
    for (const JudgingLight& light : lights_) {
      Stages stages;
      trial.indirect(light.direct, indirect, stages);
      times.add(stages);
      errors.add(as_image(indirect), as_image(light.indirect));
    }
    row.milliseconds = times.medians(), row.indirect = errors.mean();
  }

  StudyRow judge_frames(const ShadowFrames& shadows, const StudyRow& transfer,
                        const TransferTrial& trial) const {
    StudyRow row = row_of(StudyKind::frame, shadows.setting + " " + transfer.setting);
    row.bytes = shadows.bytes + transfer.bytes;
    ErrorMean direct, indirect, whole;
    std::vector<vec3> irradiance(samples().size());
    for (std::size_t l = 0; l < frames_.size(); ++l) {
      Stages ignored;
      trial.indirect(direct_of(l, shadows.visibility[l]), irradiance, ignored);
      const Image far = view_->indirect(irradiance);
      direct.add(shadows.direct[l], frames_[l].direct, counts_);
      indirect.add(far, frames_[l].indirect, counts_);
      whole.add(sum(shadows.direct[l], far), sum(frames_[l].direct, frames_[l].indirect), counts_);
    }
    row.direct = direct.mean(), row.indirect = indirect.mean(), row.whole = whole.mean();
    return row;
  }

  const PcaStudyOptions& o_;
  const PcaRoomOptions& room_;
  const Inputs& in_;
  const EmbreeTracer& tracer_;
  const Threads& threads_;
  json seconds_ = json::object();  ///< before the samples, which fill it
  RoomSamples samples_;
  float softening_ = 0;
  std::optional<RoomSolver> solver_;
  std::optional<TrialRoom> trial_;
  std::vector<JudgingLight> lights_;
  std::optional<PcaView> view_;
  std::vector<bool> counts_;
  std::vector<ExactFrame> frames_;
  std::vector<ShadowFrames> shadow_frames_;
};

}  // namespace

PcaStudy::PcaStudy(const PcaStudyOptions& options, const Inputs& in, const Threads& threads)
    : options_(options), in_(in), threads_(threads), tracer_(in.scene) {}

void PcaStudy::add_room(std::size_t samples, std::size_t clusters) {
  PcaRoomOptions room = room_options(options_.base);
  room.samples.count = samples, room.clusters.count = clusters;
  Judge judge(options_, room, in_, tracer_, threads_);
  if (unseen_.empty()) unseen_ = free_positions(judge.flights(), options_.unseen, room.seed ^ unseen_seed);
  if (judge.is_empty() || unseen_.empty())
    throw InputError(options_.base.common.scene.string(),
                     "particles from the camera or --start reach no surface, or no free space between any",
                     "name points inside the room by --start");
  judge.run(unseen_, result_.rooms.empty() && !options_.pictures.empty(), result_);
}

}  // namespace coppice::program
