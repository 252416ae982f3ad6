// How a BRDF meets a cluster of lights.
#pragma once

namespace coppice {

enum class Lobes {
  sampled,   ///< at the cluster's mean direction (Cuts Eq. 5): misses highlights narrower than the cluster
  filtered,  ///< its mean over the cluster, by a lobe that the lights' spread widens: dulls them
  refined    ///< filtered, with clusters over which the lobe changes too much replaced by their descendants:
             ///< keeps them
};

struct LobeOptions {
  Lobes lobes = Lobes::refined;
  /// Of refined: a cluster is split where (its specular light) · (growth of the lobe's squared width) exceeds
  /// this share of the point's radiance, both as luminance. Smaller is finer.
  float tolerance = 1e-3f;
};

}  // namespace coppice
