// The complete binary tree over N = 2^d leaves as arithmetic on heap ids: root 1, children of h are 2h and 2h
// + 1, leaves N … 2N-1. A node is the range [begin, end) of leaf ranks below it; no topology is stored.
#ifndef COPPICE_SHARED_NODE_H
#define COPPICE_SHARED_NODE_H
#include <coppice/shared/language.h>

COPPICE_BEGIN

/// Heap id of the node that covers the leaves [begin, end). Precondition: the range is that of a node.
COPPICE_FUNCTION uint node_of_range(uint leaf_count, uint begin, uint end) {
  return (leaf_count + begin) >> count_trailing_zeros(end - begin);
}

/// Depth-first successor of the subtree of h, without a stack: 1 after the last (Coppice's stackless walk).
COPPICE_FUNCTION uint node_after(uint h) { return (h + 1u) >> count_trailing_zeros(h + 1u); }

COPPICE_END
#endif
