// Depth-first walk of the tree without a stack.
#pragma once

#include <coppice/shared/node.h>

#include <cstdint>

namespace coppice {

/// Calls descend(h) on nodes from left to right, beginning at the root; where it returns false the subtree of
/// h is done. Leaves are never descended. No stack, no stored links: the next subtree is arithmetic
/// (shared/node.h).
template <class Descend>
void walk_tree(std::uint32_t leaf_count, Descend&& descend) {
  if (leaf_count == 0) return;
  std::uint32_t h = 1;
  do {
    const bool into = descend(h) && h < leaf_count;
    h = into ? 2 * h : node_after(h);
  } while (h != 1);
}

}  // namespace coppice
