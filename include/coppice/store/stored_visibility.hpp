// What a store holds: all that relighting keeps of a precomputation.
#pragma once

#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/receiver_mesh.hpp>
#include <coppice/relight/visibility_cut_selector.hpp>
#include <coppice/store/settings.hpp>
#include <coppice/tree/light_tree.hpp>
#include <vector>

namespace coppice {

/// Invariants: `tree` is over lights.size() lights; one receiver and one cut a corner of the mesh, in order,
/// unless the mesh is empty; cuts over the tree, each with horizon_of(its receiver, weight); all floats
/// finite; faces split only at corners and at middles of edges, as refine_receivers splits them.
template <Quantised Value>
struct StoredVisibility {
  Settings settings;
  LightTree tree;
  std::vector<vec4> lights;  ///< position, 1; or unit direction towards the light, 0
  ReceiverMesh mesh;
  std::vector<Receiver> receivers;  ///< `inward` serves the precomputation only: read as zero
  CutWeight weight = CutWeight::cosine;
  MaskedCuts<Value> cuts;
  std::vector<float> scales;  ///< what a receiver's values are multiplied by; empty: by 1
};

}  // namespace coppice
