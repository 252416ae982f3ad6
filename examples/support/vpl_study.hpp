// Measures how the light of VPLs is gathered against the sum over all of them.
#pragma once

#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/gather/glossy_points.hpp>
#include <coppice/gather/vpl_bounces.hpp>
#include <coppice/trade/errors.hpp>
#include <string>
#include <support/vpl_options.hpp>

namespace coppice::program {

/// A way to gather at given points.
struct GatherSetting {
  std::string name;  ///< as on the command line
  VplTreeOptions tree{};
  Criterion criterion = Criterion::bound;
  float threshold = 0.01f;
  std::optional<MinMaxCut> min_max{};
  std::optional<VplChoice> traced{};
};

/// Points and VPLs of a scene, all of them shining ones' leaves under one light.
struct VplSubject {
  Scene scene;
  Camera camera;
  Raster raster;
  std::vector<CameraHit> hits;
  std::vector<GlossyPoint> points;  ///< that show no emitter
  std::vector<VplNode> leaves;      ///< that shine
  std::size_t placed = 0;           ///< VPLs, with those in the dark
};

/// What one setting costs, and how far off it is.
struct GatherMeasurement {
  GatherSetting setting;
  std::size_t least = 0, most = 0;  ///< nodes, or rays, a point
  double mean = 0, tests = 0;       ///< a point
  double microseconds = 0;          ///< a point, one thread
  ImageErrors errors{};
  double bias = 0;  ///< Σ luminance over that of the reference, less 1
};

/// The sum over VPLs, in SIMD, those below a horizon passed over.
struct BruteForce {
  std::vector<vec3> radiance;
  double microseconds = 0;      ///< a point, one thread, over VPLs that shine
  double microseconds_all = 0;  ///< over as many as were placed
};

/// Points of whole tiles of 16 × 16 pixels, about `count`, spread over the image.
std::vector<GlossyPoint> spread_points(const VplSubject& subject, std::size_t count);

BruteForce sum_all(const VplSubject& subject, std::span<const GlossyPoint> points, int repeat);

/// Every VPL with its shadow ray.
std::vector<vec3> sum_all_traced(const VplSubject& subject, std::span<const GlossyPoint> points,
                                 const EmbreeTracer& tracer, const Threads& threads);

/// Points go with their radiance by pixel. The median time of `repeat` runs, grouping included, the tree not.
GatherMeasurement measure_gather(const VplSubject& subject, const VplTree& tree,
                                 std::span<const GlossyPoint> points, std::span<const vec3> reference,
                                 const GatherSetting& setting, const EmbreeTracer& tracer, int repeat);

/// Radiance by point, in the points' order.
std::vector<vec3> gather_at(const VplSubject& subject, const VplTree& tree,
                            std::span<const GlossyPoint> points, const GatherSetting& setting,
                            const EmbreeTracer& tracer, std::vector<std::uint32_t>& nodes, std::size_t& tests,
                            const GroupOptions& options = {});

/// Errors of values by point.
ImageErrors point_errors(std::span<const vec3> values, std::span<const vec3> reference);

/// Σ luminance of values by point over that of the reference, less 1; 0 where the reference is black.
double relative_bias(std::span<const vec3> values, std::span<const vec3> reference);

}  // namespace coppice::program
