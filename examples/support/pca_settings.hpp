// Settings of visibility and transfer as short texts, as a sweep names them.
#pragma once

#include <optional>
#include <string>
#include <support/room_shadows.hpp>
#include <support/room_transfer.hpp>

namespace coppice::program {

/// "lattice:20:points=8000", "depth:50:plain", "rays"
struct VisibilitySetting {
  std::string text;
  RoomShadowOptions options;
};

/// "transport:20", "paper:10:no-mean", "uncentred:20:sparse=0.2"
struct TransferSetting {
  std::string text;
  RoomTransferOptions options;
  bool mean = true;                ///< of centred bases: S·μ is added (PCA Eq. 10 lacks it)
  std::optional<double> sparse{};  ///< share of the matrix' entries that are kept, in place of patterns
};

/// KIND[:RANK] and behind it, for the lattice, :points=N, :training=N, :smooth, for depth :directions=N,
/// :intervals=N, :plain, :sphere, and for both :bits=8 or 16. What is not named is as in `base`. Throws
/// InputError naming --visibility for anything else.
VisibilitySetting parse_visibility(const std::string& text, const RoomShadowOptions& base);

/// BASIS:RANK and behind it :patterns=N, :bits=8 or 16, :no-mean (of the paper's basis), :sparse=SHARE.
/// Throws InputError naming --basis for anything else.
TransferSetting parse_transfer(const std::string& text, const RoomTransferOptions& base);

}  // namespace coppice::program
