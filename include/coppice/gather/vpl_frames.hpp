// The VPL tree of an animation: refit along what changes, and built anew when it has grown poor.
#pragma once

#include <coppice/gather/vpl_tree.hpp>
//
#include <cstring>

namespace coppice::inline HWY_NAMESPACE {

/// Keeps a tree over all VPLs of a scene, dark ones with them, from frame to frame.
class VplFrames {
 public:
  /// What a frame has cost.
  struct Update {
    std::size_t changed = 0;  ///< VPLs whose leaves differ from the last frame's
    bool is_rebuilt = false;
    double looseness = 0;  ///< VplTree::looseness
  };

  /// A tree whose splits leave less than so much of what they would tell apart when it was built is built
  /// anew: where 1 - looseness has fallen below this share of its first value.
  explicit VplFrames(const VplTreeOptions& options = {}, double least_share = 0.85)
      : options_(options), least_share_(least_share) {}

  /// Leaves of the next frame, by VPL. The tree is what VplTree::set() would make of it, or a new one.
  Update update(std::vector<VplNode> leaves) {
    const bool is_first = leaves.size() != leaves_.size() || tree_.leaf_count() == 0;
    find_changes(leaves, is_first);
    leaves_ = std::move(leaves);
    if (is_first) return build();
    tree_.refit(changed_, leaves_);
    const double looseness = tree_.looseness();
    if (1 - looseness < least_share_ * (1 - built_looseness_)) return build();
    return {changed_.size(), false, looseness};
  }

  const VplTree& tree() const { return tree_; }
  std::span<const VplNode> leaves() const { return leaves_; }

 private:
  /// Bit for bit: a leaf that is computed from the same numbers is the same.
  void find_changes(std::span<const VplNode> leaves, bool is_first) {
    changed_.clear();
    for (std::uint32_t i = 0; i < leaves.size(); ++i)
      if (is_first || std::memcmp(&leaves[i], &leaves_[i], sizeof(VplNode)) != 0) changed_.push_back(i);
  }

  Update build() {
    tree_ = VplTree(leaves_, options_);
    built_looseness_ = tree_.looseness();
    return {changed_.size(), true, built_looseness_};
  }

  VplTreeOptions options_;
  double least_share_, built_looseness_ = 0;
  std::vector<VplNode> leaves_;
  std::vector<std::uint32_t> changed_;
  VplTree tree_;
};

}  // namespace coppice::inline HWY_NAMESPACE
