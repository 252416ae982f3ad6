// The backend that gathers the light of VPLs: this processor or a Vulkan device.
#pragma once

#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/gather/group_lists.hpp>
#include <memory>
#include <support/vpl_options.hpp>

namespace coppice::program {

class VplGatherer {
 public:
  virtual ~VplGatherer() = default;
  /// Gathers from this tree until the next call; it stays where it is and as it is.
  virtual void use(const VplTree& tree) = 0;
  virtual Gathered gather(const PointGroups& groups, const EmbreeTracer& tracer) = 0;
};

/// That of options.common.backend. Options and threads outlive it. Throws InputError where it cannot be had.
std::unique_ptr<VplGatherer> make_vpl_gatherer(const VplSystemOptions& options, const Threads& threads);

}  // namespace coppice::program
