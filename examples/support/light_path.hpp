// Lights that move, change colour and swell from frame to frame.
#pragma once

#include <coppice/scene/motion.hpp>
#include <coppice/transfer/sized_light.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace coppice::program {

/// A light by keyframes, all at the same times.
struct LightPath {
  Keyframes<vec3> position;   ///< metres
  Keyframes<vec3> intensity;  ///< W/sr, linear RGB
  Keyframes<vec3> radius;     ///< metres, in x

  SizedLight at(float time) const {
    return {point_light(position.at(time), intensity.at(time)), radius.at(time).x};
  }
  float duration() const { return position.times.empty() ? 0 : position.times.back(); }
};

/// Reads {"lights": [{"interpolation": "linear", "keys": [{"time": 0, "position": [x, y, z], "intensity":
/// [r, g, b], "radius": 0.1}, ...]}, ...]}. Interpolation is "step", "linear" or "smooth", a curve through
/// the keys without corners (the default). Intensity and radius may be left out: a key then has those of the
/// one before it; the first has 1 W/sr and 0 m. Throws InputError naming the file, the light, the key and the
/// remedy.
std::vector<LightPath> read_light_paths(const std::filesystem::path& file);

/// A light through points given as "x,y,z", a second from each to the next. Throws InputError naming
/// `option` for anything else.
LightPath path_through(const std::string& option, const std::vector<std::string>& points,
                       const vec3& intensity, float radius);

/// "x,y,z" or "r,g,b". Throws InputError naming `option` for anything else.
vec3 parse_vector(const std::string& option, const std::string& text);

}  // namespace coppice::program
