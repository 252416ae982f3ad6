// Trees of any β over a scene whose visibility is kept, without tracing it again.
#pragma once

#include <coppice/embree/threads.hpp>
#include <coppice/relight/cut_relighting.hpp>

namespace coppice::bench {

/// What the pilots see. Precondition: the bits are kept, and the tree is the geometric one.
inline PilotVisibility pilot_visibility(const CutRelighting<>& relighting, const PilotOptions& options) {
  PilotVisibility pilot{choose_pilots(relighting.receivers(), options), {}, 0};
  pilot.rows = VisibilityRows(relighting.tree().leaf_count(), pilot.pilots.receivers);
  const std::size_t words = words_for_bits(relighting.tree().leaf_count());
  for (std::size_t i = 0; i < pilot.rows.size(); ++i)
    std::ranges::copy(relighting.bits().subspan(pilot.pilots.receivers[i] * words, words),
                      pilot.rows[i].begin());
  return pilot;
}

inline std::vector<LightSample> light_samples(const CutRelighting<>& relighting) {
  std::vector<LightSample> samples;
  for (const vec3& d : relighting.directions()) samples.push_back({d, vec3(0)});
  return samples;
}

/// The tree that CutRelighting has for this β.
inline LightTree tree_for(const CutRelighting<>& relighting, PilotVisibility pilot, float beta,
                          const PilotOptions& options) {
  if (beta == 1) return relighting.tree();
  return build_data_driven_tree(light_samples(relighting), relighting.tree(), pilot, beta, options,
                                Threads());
}

}  // namespace coppice::bench
