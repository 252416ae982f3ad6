#include "animation.hpp"

#include <utility>

#include "accessor.hpp"

namespace coppice::gltf {
namespace {

constexpr std::size_t most_keys = std::size_t{1} << 24;

// Reads the samplers of one animation.
class SamplerReader {
 public:
  SamplerReader(const Document& document, KeyBudget& budget)
      : document_(document),
        budget_(budget),
        animation_(document.model.animations.front()),
        item_(item_name("animation", 0, animation_.name)) {}

  Keyframes<vec3> vectors(int sampler) const {
    return read<vec3>(sampler, TINYGLTF_TYPE_VEC3,
                      [](const Elements& values, std::size_t i) { return values.as_vec3(i); });
  }

  Keyframes<glm::quat> rotations(int sampler) const {
    auto track = read<glm::quat>(sampler, TINYGLTF_TYPE_VEC4, [](const Elements& values, std::size_t i) {
      const vec4 v = values.as_vec4(i);
      return glm::quat(v.w, v.x, v.y, v.z);
    });
    make_unit(track, sampler_item(sampler) + ", output");
    return track;
  }

 private:
  std::string sampler_item(int sampler) const {
    return item_ + ", " + item_name("sampler", std::size_t(sampler));
  }

  Interpolation interpolation_of(int sampler) const {
    if (!has_item(animation_.samplers, sampler))
      document_.fail(item_, "there is no sampler " + std::to_string(sampler));
    const std::string& name = animation_.samplers[std::size_t(sampler)].interpolation;
    if (name == "STEP") return Interpolation::step;
    if (name == "LINEAR") return Interpolation::linear;
    if (name == "CUBICSPLINE") return Interpolation::cubic_spline;
    document_.fail(sampler_item(sampler), "interpolation " + one_line(name, 20) + " is unknown");
  }

  template <class Value, class Convert>
  Keyframes<Value> read(int sampler, int type, Convert convert) const {
    Keyframes<Value> track;
    track.interpolation = interpolation_of(sampler);
    const tinygltf::AnimationSampler& source = animation_.samplers[std::size_t(sampler)];
    track.times = times(source.input, sampler_item(sampler) + ", input");
    const std::string item = sampler_item(sampler) + ", output";
    const Elements values = elements(source.output, type, item);
    if (values.count != track.values_a_key() * track.times.size())
      document_.fail(item, std::to_string(values.count) + " values do not match " +
                               std::to_string(track.times.size()) + " times");
    track.values.resize(values.count);
    for (std::size_t i = 0; i < values.count; ++i) {
      track.values[i] = convert(values, i);
      for (int c = 0; c < int(Value::length()); ++c)
        if (!std::isfinite(track.values[i][c]))
          document_.fail(item, "element " + std::to_string(i) + " is not finite");
    }
    return track;
  }

  std::vector<float> times(int accessor, const std::string& item) const {
    const Elements elements = this->elements(accessor, TINYGLTF_TYPE_SCALAR, item);
    if (elements.count == 0) document_.fail(item, "it has no times");
    budget_.admit(elements.count, item);
    std::vector<float> times(elements.count);
    for (std::size_t i = 0; i < times.size(); ++i) {
      times[i] = elements.component(i, 0);
      if (!(times[i] >= 0) || !std::isfinite(times[i]))
        document_.fail(item, "time " + std::to_string(i) + " is negative or not finite");
      if (i > 0 && !(times[i] > times[i - 1]))
        document_.fail(item, "time " + std::to_string(i) + " is not later than the one before");
    }
    return times;
  }

  // glTF 2.0, section 3.11: floats, or normalised integers where values lie in [-1, 1].
  Elements elements(int accessor, int type, const std::string& item) const {
    const Elements elements = attribute_elements(document_, accessor, type, item);
    const bool is_float = elements.component_type == TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (!is_float && !(type == TINYGLTF_TYPE_VEC4 && elements.normalized))
      document_.fail(item, type == TINYGLTF_TYPE_VEC4 ? "rotations must be floats or normalised integers"
                                                      : "its values must be floats");
    return elements;
  }

  // Tangents are scaled with their keys, so that the curve keeps its shape.
  void make_unit(Keyframes<glm::quat>& track, const std::string& item) const {
    const std::size_t a_key = track.values_a_key();
    for (std::size_t key = 0; key < track.times.size(); ++key) {
      const glm::dquat value(track.value(key));
      const double size = glm::length(value);
      if (!(size > 1e-6))
        document_.fail(item, "the rotation of key " + std::to_string(key) + " is not a unit quaternion");
      for (std::size_t i = a_key * key; i < a_key * (key + 1); ++i)
        track.values[i] = glm::quat(glm::dquat(track.values[i]) / size);
    }
  }

  const Document& document_;
  KeyBudget& budget_;
  const tinygltf::Animation& animation_;
  std::string item_;
};

// Sorts the channels of one animation by node.
class ChannelReader {
 public:
  ChannelReader(const Document& document, KeyBudget& budget, Warnings& warnings)
      : document_(document), warnings_(warnings), samplers_(document, budget) {}

  void read(const tinygltf::AnimationChannel& channel) {
    const auto node = std::size_t(channel.target_node);
    const std::string& path = channel.target_path;
    if (path == "weights")
      return warnings_.add(node_name(document_, node) +
                           ": morph targets are not supported, its shape stays at rest");
    if (path != "translation" && path != "rotation" && path != "scale")
      return warnings_.count("animation channels of unknown properties ignored");
    if (!document_.model.nodes[node].matrix.empty())
      document_.fail(node_name(document_, node), "it is animated and has a matrix");
    NodeTracks& tracks = tracks_[node];
    if (path == "translation") set(tracks.translation, samplers_.vectors(channel.sampler), node, path);
    if (path == "rotation") set(tracks.rotation, samplers_.rotations(channel.sampler), node, path);
    if (path == "scale") set(tracks.scale, samplers_.vectors(channel.sampler), node, path);
  }

  std::map<std::size_t, NodeTracks> take() { return std::move(tracks_); }

 private:
  template <class Track>
  void set(std::optional<Track>& place, Track track, std::size_t node, const std::string& path) const {
    if (place) document_.fail(node_name(document_, node), "two channels of one animation set its " + path);
    place = std::move(track);
  }

  const Document& document_;
  Warnings& warnings_;
  SamplerReader samplers_;
  std::map<std::size_t, NodeTracks> tracks_;
};

}  // namespace

void KeyBudget::admit(std::size_t count, const std::string& item) {
  count_ += count;
  if (count_ > most_keys)
    document_.fail(item, "the scene exceeds 2^24 keyframes", "sample its animation more coarsely");
}

std::map<std::size_t, NodeTracks> read_tracks(const Document& document, const std::vector<PlacedNode>& nodes,
                                              KeyBudget& budget, Warnings& warnings) {
  const tinygltf::Model& model = document.model;
  if (!document.animation_complaint.empty()) document.fail("animations", document.animation_complaint);
  if (model.animations.empty()) return {};
  warnings.count("animations after the first ignored", model.animations.size() - 1);
  std::vector<char> in_scene(model.nodes.size(), 0);
  for (const PlacedNode& placed : nodes) in_scene[placed.node] = 1;
  ChannelReader reader(document, budget, warnings);
  for (const tinygltf::AnimationChannel& channel : model.animations.front().channels) {
    if (channel.target_node == -1) continue;  // glTF 2.0, section 3.11: an extension's own
    if (!has_item(model.nodes, channel.target_node))
      document.fail("animation 0", "there is no node " + std::to_string(channel.target_node));
    if (in_scene[std::size_t(channel.target_node)]) reader.read(channel);
  }
  return reader.take();
}

}  // namespace coppice::gltf
