#include <coppice/core/error.hpp>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <support/light_path.hpp>

namespace coppice::program {
namespace {

using nlohmann::json;

/// A Catmull-Rom spline, by uneven times; positions alone, as colours and sizes must not overshoot.
Keyframes<vec3> curve_through(const Keyframes<vec3>& keys) {
  Keyframes<vec3> curve{Interpolation::cubic_spline, keys.times, {}};
  const std::size_t last = keys.times.size() - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    const std::size_t a = k == 0 ? 0 : k - 1, b = std::min(k + 1, last);
    const vec3 tangent =
        a == b ? vec3(0) : (keys.values[b] - keys.values[a]) / (keys.times[b] - keys.times[a]);
    curve.values.insert(curve.values.end(), {tangent, keys.values[k], tangent});
  }
  return curve;
}

/// The lights of one file, and what errors are about.
class PathReader {
 public:
  explicit PathReader(const std::filesystem::path& file) : file_(file.string()) {}

  std::vector<LightPath> read() {
    const json document = parse();
    std::vector<LightPath> paths;
    for (const json& light : list(document, "lights")) {
      where_ = "light " + std::to_string(paths.size());
      paths.push_back(path(light));
    }
    return paths;
  }

 private:
  [[noreturn]] void refuse(const std::string& problem, const std::string& remedy) const {
    throw InputError(file_ + (where_.empty() ? "" : ", " + where_), problem, remedy);
  }

  json parse() const {
    std::ifstream stream(file_);
    if (!stream) refuse("cannot be read", "check the name and the permissions");
    json document = json::parse(stream, nullptr, false);
    if (document.is_discarded()) refuse("is no JSON", "write {\"lights\": [...]}");
    return document;
  }

  const json& list(const json& object, const char* name) const {
    if (!object.is_object() || !object.contains(name) || !object[name].is_array())
      refuse(std::string("has no list \"") + name + "\"", "add it");
    return object[name];
  }

  float number(const json& value, const std::string& name) const {
    if (!value.is_number() || !std::isfinite(value.get<float>()))
      refuse("\"" + name + "\" is no finite number", "write one");
    return value.get<float>();
  }

  vec3 vector(const json& value, const std::string& name) const {
    if (!value.is_array() || value.size() != 3)
      refuse("\"" + name + "\" is no list of three numbers", "write one");
    return {number(value[0], name), number(value[1], name), number(value[2], name)};
  }

  LightPath path(const json& light) {
    LightPath result;
    const std::string name = where_;
    for (const json& key : list(light, "keys")) {
      where_ = name + ", key " + std::to_string(result.position.times.size());
      add(result, key);
    }
    where_ = name;
    if (result.position.times.empty()) refuse("has no keys", "give it one at least");
    smooth(result, light.value("interpolation", json("smooth")));
    return result;
  }

  void add(LightPath& path, const json& key) const {
    if (!key.is_object() || !key.contains("position")) refuse("has no \"position\"", "add [x, y, z]");
    const float time = key.contains("time") ? number(key["time"], "time") : float(path.position.times.size());
    if (!path.position.times.empty() && !(time > path.position.times.back()))
      refuse("\"time\" does not come after that of the key before", "sort the keys by time");
    vec3 intensity = path.intensity.values.empty() ? vec3(1) : path.intensity.values.back();
    vec3 radius = path.radius.values.empty() ? vec3(0) : path.radius.values.back();
    if (key.contains("intensity")) intensity = vector(key["intensity"], "intensity");
    if (key.contains("radius")) radius = vec3(number(key["radius"], "radius"));
    if (glm::any(glm::lessThan(intensity, vec3(0)))) refuse("\"intensity\" is below 0", "use 0 or more");
    if (radius.x < 0) refuse("\"radius\" is below 0", "use 0 for a point");
    add_key(path, time, vector(key["position"], "position"), intensity, radius);
  }

  static void add_key(LightPath& path, float time, const vec3& position, const vec3& intensity,
                      const vec3& radius) {
    const auto append = [time](Keyframes<vec3>& keys, const vec3& value) {
      keys.times.push_back(time);
      keys.values.push_back(value);
    };
    append(path.position, position), append(path.intensity, intensity), append(path.radius, radius);
  }

  void smooth(LightPath& path, const json& word) const {
    if (word == "step")
      for (auto* keys : {&path.position, &path.intensity, &path.radius})
        keys->interpolation = Interpolation::step;
    else if (word == "smooth")
      path.position = curve_through(path.position);
    else if (word != "linear")
      refuse("\"interpolation\" is none of step, linear, smooth", "use one of these");
  }

  std::string file_, where_;
};

}  // namespace

std::vector<LightPath> read_light_paths(const std::filesystem::path& file) { return PathReader(file).read(); }

vec3 parse_vector(const std::string& option, const std::string& text) {
  vec3 v(0);
  int end = 0;
  if (std::sscanf(text.c_str(), "%f,%f,%f%n", &v.x, &v.y, &v.z, &end) != 3 ||
      std::size_t(end) != text.size() || !is_finite(v))
    throw InputError(option, "'" + text + "' is not three numbers", "write them as in 1,1.5,-2");
  return v;
}

LightPath path_through(const std::string& option, const std::vector<std::string>& points,
                       const vec3& intensity, float radius) {
  LightPath path;
  for (const std::string& text : points) {
    path.position.times.push_back(float(path.position.times.size()));
    path.position.values.push_back(parse_vector(option, text));
  }
  path.intensity = {Interpolation::linear, {0}, {intensity}};
  path.radius = {Interpolation::linear, {0}, {vec3(radius)}};
  path.position = curve_through(path.position);
  return path;
}

}  // namespace coppice::program
