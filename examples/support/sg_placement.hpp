// The light of a frame's map, and the cones that it asks for.
#pragma once

#include <coppice/embree/threads.hpp>
#include <coppice/sg/lit_cones.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <support/sg_options.hpp>

namespace coppice::program {

class SgPlacement {
 public:
  virtual ~SgPlacement() = default;
  /// Takes the map of a frame, not turned. Adds milliseconds to `stages`.
  virtual void take(const Image& map, nlohmann::json& stages) = 0;
  /// The cones of all points, in world space, under the map turned by so many radians.
  virtual ConeBatch place(std::span<const ShadingPoint> points, std::vector<ConeReceiver> receivers,
                          float rotation) const = 0;
  virtual std::size_t peak_count() const = 0;
};

/// That of options.placement. Options and threads outlive it.
std::unique_ptr<SgPlacement> make_sg_placement(const SgSystemOptions& options, const Threads& threads);

}  // namespace coppice::program
