// What a store holds of a prepared room: all that relighting it by moving lights keeps.
#pragma once

#include <coppice/store/settings.hpp>
#include <coppice/transfer/clustered_samples.hpp>
#include <coppice/transfer/lattice_visibility.hpp>
#include <coppice/transfer/light_transfer.hpp>
#include <variant>

namespace coppice {

/// How the samples know which lights they see; std::monostate: by shadow rays.
using StoredLightVisibility =
    std::variant<std::monostate, LatticeVisibility<std::int8_t>, LatticeVisibility<std::int16_t>>;
/// How direct light at the samples becomes indirect light.
using StoredLightTransfer = std::variant<LightTransfer<std::int8_t>, LightTransfer<std::int16_t>>;

/// Invariants, each checked on writing and on reading; whoever holds a room that was read can follow every
/// index of it:
/// - samples.ends do not fall and end at samples.size(); so does all that is by cluster in the other two,
///   whose ends are the same. Areas are not below 0.
/// - The lattice has size.x · size.y · size.z numbers (sizes below 2^30, spacing above 0), each `none` or
///   below count(); no numbers where it has no size.
/// - A cluster has `rank` scales, rank · (its samples) coefficients and rank · (rows of its index) rows; its
///   index has a bit for each lattice point and none behind, and `before` counts them.
/// - A cluster's projection and patterns are as long as it has samples, one behind the other.
/// - The three mixes have a row for each pattern and as many columns as there are coefficients, or all one
///   more. There are no offsets, or one for each coefficient.
/// - All floats are finite.
/// That each sample's triangle is one of the scene's is for the program to check: a room knows no scene.
struct StoredRoom {
  Settings settings;
  ClusteredSamples samples;
  StoredLightVisibility visibility;
  StoredLightTransfer transfer;
};

}  // namespace coppice
