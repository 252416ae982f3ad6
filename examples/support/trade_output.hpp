// What trade writes and prints.
#pragma once

#include <coppice/relight/cut_relighting.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <support/measure.hpp>
#include <support/program.hpp>

namespace coppice::program {

/// A row a point, with the names of the inputs, so that files of several runs can be put together.
std::string csv(const Measurements& measured, const CutRelighting<>& relighting, const CommonOptions& inputs);

/// Rows of points and of both twins as Markdown, under a line that tells the scene's size.
std::string table(const Measurements& measured, const CutRelighting<>& relighting);

/// Time against error as SVG: a line for each kind of cuts and lobes, through the points that no other of the
/// line beats in both.
std::string plot(const Measurements& measured);

/// "σ 2, 64 nodes, cosine-optimal, refined: 34.1 ms, relRMSE 0.82%"
std::string description(const OperatingPoint& point);

nlohmann::json point_json(const OperatingPoint& point, const CutRelighting<>& relighting);

}  // namespace coppice::program
