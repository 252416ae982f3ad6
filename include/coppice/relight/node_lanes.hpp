// A register of light nodes.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/shared/layout.h>

#include <vector>

namespace coppice::inline HWY_NAMESPACE {

/// Fields of Lanes::width nodes, by the names of LightNode. Of a LocalLightNode `spread` is the variance, x,
/// y, z the position and `solid_angle` its w.
struct NodeLanes {
  Lanes red, green, blue, spread, x, y, z, solid_angle;
};

namespace merging {

/// Every fourth float from `from` on, for four phases: Lanes::width tuples.
struct FourLanes {
  Lanes v[4];
};
HWY_INLINE FourLanes load_tuples(const float* from) {
  FourLanes r;
  hn::LoadInterleaved4(Lanes::Tag(), from, r.v[0].values, r.v[1].values, r.v[2].values, r.v[3].values);
  return r;
}

}  // namespace merging

/// Lanes::width nodes that lie one after the other. A node is two tuples of four floats, so that the first
/// load gives both tuples of the lower half of the lanes: tuples of power and of direction in turn.
template <class Node>
HWY_INLINE NodeLanes load_nodes(const Node* nodes) {
  static_assert(sizeof(Node) == 8 * sizeof(float));
  const float* from = reinterpret_cast<const float*>(nodes);
  const auto low = merging::load_tuples(from), high = merging::load_tuples(from + 4 * Lanes::width);
#if HWY_TARGET == HWY_SCALAR
  return {low.v[0], low.v[1], low.v[2], low.v[3], high.v[0], high.v[1], high.v[2], high.v[3]};
#else
  const auto even = [&](int i) {
    return Lanes(hn::ConcatEven(Lanes::Tag(), high.v[i].values, low.v[i].values));
  };
  const auto odd = [&](int i) {
    return Lanes(hn::ConcatOdd(Lanes::Tag(), high.v[i].values, low.v[i].values));
  };
  return {even(0), even(1), even(2), even(3), odd(0), odd(1), odd(2), odd(3)};
#endif
}

/// Room for `count` nodes and a register beyond them.
template <class Node>
void make_room(std::vector<Node>& nodes, std::size_t count) {
  if (nodes.size() < count + Lanes::width) nodes.resize(count + Lanes::width, Node{});
}

}  // namespace coppice::inline HWY_NAMESPACE
