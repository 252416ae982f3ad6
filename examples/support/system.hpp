// A scene made ready for one kind of light, frame by frame.
#pragma once

#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/relight/deferred.hpp>
#include <coppice/relight/traced_lighting.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <support/knobs.hpp>
#include <support/program.hpp>
#include <vector>

namespace coppice::program {

/// What lights the scene.
enum class LightKind {
  environment,  ///< the map of --env
  scene,        ///< the file's own lights and shining surfaces
  indirect      ///< the same, and one bounce from the surfaces that they light
};
inline const Words<LightKind> light_words{
    {"env", LightKind::environment}, {"scene", LightKind::scene}, {"indirect", LightKind::indirect}};

/// How it is known which lights a point sees.
enum class Visibility {
  stored,  ///< precomputed cuts
  traced   ///< a shadow ray a cluster, nothing precomputed
};
inline const Words<Visibility> visibility_words{{"stored", Visibility::stored},
                                                {"traced", Visibility::traced}};

struct SystemOptions {
  CommonOptions common;
  CutOptions cut;
  Knobs knobs;
  LightKind lights = LightKind::environment;
  Visibility visibility = Visibility::stored;
  std::size_t emitters = 4096;                        ///< surface lights at most, on shining surfaces
  std::size_t bounces = 32768;                        ///< surface lights at most, on lit surfaces
  float trace_tolerance = TracedOptions{}.tolerance;  ///< TracedOptions::tolerance
  std::filesystem::path store;                        ///< where visibility is kept; empty: nowhere
  int frames = 1;
  bool animate = false;    ///< frames are spread over the file's animation
  bool reference = false;  ///< System::reference will be called
};

/// One frame.
struct RenderedFrame {
  Image image;
  DirectImage direct;           ///< what is covered, and what shines itself
  std::vector<float> cut_size;  ///< a pixel: clusters, or shadow rays where visibility is traced
  std::vector<std::pair<std::string, Image>>
      parts;  ///< what the image is the sum of, where there are several
  nlohmann::json report;
};

class System {
 public:
  virtual ~System() = default;
  virtual RenderedFrame render(int frame) = 0;
  /// The image of the last frame from all lights, each by itself; tells its time in `report`.
  virtual Image reference(nlohmann::json& report) = 0;
  /// For the report: counts, and seconds of each stage.
  virtual nlohmann::json preparation() const = 0;
};

/// Inputs and tracer outlive it. Where a store is named it is read if it fits, and written otherwise.
std::unique_ptr<System> make_environment_system(const SystemOptions& options, Inputs& in,
                                                const EmbreeTracer& tracer, const Threads& threads);
std::unique_ptr<System> make_local_system(const SystemOptions& options, Inputs& in,
                                          const EmbreeTracer& tracer, const Threads& threads);

/// Radians by which a frame turns the environment.
float turn_of_frame(const SystemOptions& options, int frame);

/// Seconds into the animation at which a frame of so many stands.
float time_of_frame(int frames, const Scene& scene, int frame);

/// Means over pixels of numbers a point.
std::vector<float> resolve_counts(const ShadingBuffer& buffer, const Raster& raster,
                                  std::span<const std::uint32_t> counts);

/// Σ of what points reflect and what shines itself.
Image add_emission(Image reflected, const DirectImage& direct);

}  // namespace coppice::program
