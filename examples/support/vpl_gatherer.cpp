#include <coppice/core/error.hpp>
#include <support/vpl_gatherer.hpp>
#ifdef COPPICE_HAS_VULKAN
#include <coppice/vulkan/vpl_shader.hpp>
#endif

namespace coppice::program {

namespace {

std::vector<WalkMark> marks_of(const VplSystemOptions& options, const VplTree& tree) {
  return options.min_max ? min_max_marks(tree, *options.min_max) : std::vector<WalkMark>();
}

class CpuGatherer : public VplGatherer {
 public:
  CpuGatherer(const VplSystemOptions& options, const Threads& threads)
      : options_(options), threads_(threads) {}

  void use(const VplTree& tree) override { tree_ = &tree, marks_ = marks_of(options_, tree); }

  Gathered gather(const PointGroups& groups, const EmbreeTracer& tracer) override {
    const float threshold = threshold_of(options_);
    if (options_.is_traced)
      return gather_traced(*tree_, groups, threshold, options_.choice, tracer, options_.common.seed,
                           threads_);
    if (options_.criterion == Criterion::bound) return gather_by_bound(*tree_, groups, threshold, threads_);
    return gather_by_angle(*tree_, groups.points, threshold, marks_, threads_);
  }

 private:
  const VplSystemOptions& options_;
  const Threads& threads_;
  const VplTree* tree_ = nullptr;
  std::vector<WalkMark> marks_;
};

#ifdef COPPICE_HAS_VULKAN
class VulkanGatherer : public VplGatherer {
 public:
  VulkanGatherer(const VplSystemOptions& options, const Threads& threads)
      : options_(options), threads_(threads), shader_(device_) {}

  /// The device filters by itself, but for what only the processor can.
  void use(const VplTree& tree) override {
    tree_ = &tree, marks_ = marks_of(options_, tree);
    if (options_.tree.filter == VplFilter::moments)
      shader_.filter(tree.nodes().subspan(tree.leaf_count()));
    else
      shader_.set_nodes(tree.nodes());
  }

  Gathered gather(const PointGroups& groups, const EmbreeTracer&) override {
    const float threshold = threshold_of(options_);
    VplGatherResult r = options_.criterion == Criterion::angle
                            ? shader_.gather_by_angle(groups.points, threshold, marks_)
                            : shader_.gather_lists(groups.points, lists_of(groups, threshold));
    return {std::move(r.radiance), std::move(r.nodes), 0};
  }

 private:
  VplLists lists_of(const PointGroups& groups, float threshold) const {
    const GroupLists cuts(*tree_, groups, threshold, threads_);
    VplLists lists;
    cuts.for_each(0, groups.size(), [&](std::size_t, auto, std::span<const std::uint32_t> nodes) {
      lists.nodes.insert(lists.nodes.end(), nodes.begin(), nodes.end());
      lists.ends.push_back(std::uint32_t(lists.nodes.size()));
    });
    lists.ends.resize(groups.size(), std::uint32_t(lists.nodes.size()));
    return lists;
  }

  const VplSystemOptions& options_;
  const Threads& threads_;
  VulkanDevice device_;
  VplShader shader_;
  const VplTree* tree_ = nullptr;
  std::vector<WalkMark> marks_;
};
#endif

}  // namespace

std::unique_ptr<VplGatherer> make_vpl_gatherer(const VplSystemOptions& options, const Threads& threads) {
  if (options.common.backend == "cpu") return std::make_unique<CpuGatherer>(options, threads);
#ifdef COPPICE_HAS_VULKAN
  return std::make_unique<VulkanGatherer>(options, threads);
#else
  throw InputError("--backend vulkan", "is not part of this build", "build with -DCOPPICE_VULKAN=ON");
#endif
}

}  // namespace coppice::program
