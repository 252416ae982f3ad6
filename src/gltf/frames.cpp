#include "frames.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

namespace coppice::gltf {
namespace {

constexpr double farthest = 1e9;          // as for coordinates
constexpr double scale_tolerance = 1e-4;  // of exported matrices and constant scale channels

// Even scale, whatever the rotation, mirrored or not: then what is rigid below it is rigid above it.
bool keeps_angles(const glm::dmat3& m) {
  const double size = length(m[0]), tolerance = scale_tolerance * size;
  return size > 0 && std::fabs(length(m[1]) - size) < tolerance &&
         std::fabs(length(m[2]) - size) < tolerance && std::fabs(dot(m[0], m[1])) < tolerance * size &&
         std::fabs(dot(m[1], m[2])) < tolerance * size && std::fabs(dot(m[2], m[0])) < tolerance * size;
}

// The rotation part of a matrix that keeps angles; of its negative where it mirrors, as -1 commutes with
// rotations.
glm::dquat rotation_of(const glm::dmat3& m) {
  const glm::dvec3 x = normalize(m[0]), y = normalize(m[1] - dot(m[1], x) * x);
  return glm::quat_cast(determinant(m) < 0 ? glm::dmat3(-x, -y, cross(x, y)) : glm::dmat3(x, y, cross(x, y)));
}

template <class Value>
float largest_component(const Value& value) {
  float largest = 0;
  for (int c = 0; c < int(Value::length()); ++c) largest = std::max(largest, std::fabs(value[c]));
  return largest;
}

template <class Value>
bool is_tangent(const Keyframes<Value>& track, std::size_t i) {
  return track.interpolation == Interpolation::cubic_spline && i % 3 != 1;
}

// The one value of a track that never leaves it by more than a share of its size.
template <class Value>
std::optional<Value> constant_value(const Keyframes<Value>& track, float tolerance) {
  const Value first = track.value(0);
  const float allowed = tolerance * largest_component(first);
  for (std::size_t i = 0; i < track.values.size(); ++i) {
    const Value& value = track.values[i];
    const Value change = is_tangent(track, i) ? value * track.times.back() : value - first;
    if (!(largest_component(change) <= allowed)) return std::nullopt;
  }
  return first;
}

// Puts the values of constant channels in place of the node's own, as exporters write channels for all that
// could move.
void settle(NodeTracks& tracks, LocalTransform& local) {
  const auto settle_one = [](auto& track, auto& place, double tolerance) {
    if (!track) return;
    if (const auto value = constant_value(*track, float(tolerance))) {
      place = std::remove_reference_t<decltype(place)>(*value);
      track.reset();
    }
  };
  settle_one(tracks.translation, local.translation, 0);
  settle_one(tracks.rotation, local.rotation, 0);
  settle_one(tracks.scale, local.scale, scale_tolerance);
}

// Moves a node's translations to the frame that surrounds its parent: points by the matrix, tangents by its
// linear part.
Keyframes<vec3> carried(Keyframes<vec3> track, const glm::dmat4& to_frame) {
  for (std::size_t i = 0; i < track.values.size(); ++i)
    track.values[i] = vec3(to_frame * glm::dvec4(glm::dvec3(track.values[i]), is_tangent(track, i) ? 0 : 1));
  return track;
}

// Interpolation commutes with this product, as it keeps the quaternions' angles.
Keyframes<glm::quat> carried(Keyframes<glm::quat> track, const glm::dmat3& to_frame) {
  const glm::dquat turn = rotation_of(to_frame), back = glm::conjugate(turn);
  for (glm::quat& q : track.values) q = glm::quat(turn * glm::dquat(q) * back);
  return track;
}

// No value of the track is longer: a Hermite spline lies within its keys and 4/27 of its tangents.
double reach_of(const Keyframes<vec3>& track) {
  double keys = 0, tangents = 0;
  for (std::size_t i = 0; i < track.values.size(); ++i) {
    double& longest = is_tangent(track, i) ? tangents : keys;
    const double size = length(glm::dvec3(track.values[i]));
    if (!(size <= longest)) longest = size;  // NaN stays
  }
  return keys + tangents * double(track.times.back());
}

Keyframes<vec3> resting_at(const glm::dvec3& translation) {
  return {Interpolation::step, {0.0f}, {vec3(translation)}};
}

class FrameFinder {
 public:
  FrameFinder(const Document& document, const std::vector<PlacedNode>& nodes, KeyBudget& budget,
              Warnings& warnings)
      : document_(document), nodes_(nodes), warnings_(warnings) {
    tracks_ = read_tracks(document, nodes, budget, warnings);
    frames_.of_nodes.resize(nodes.size());
  }

  Frames find() {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const PlacedNode& placed = nodes_[i];
      const NodeFrame parent = placed.parent == no_parent ? NodeFrame{} : frames_.of_nodes[placed.parent];
      frames_.of_nodes[i] = place(placed.node, parent);
      if (frames_.of_nodes[i].frame != world_frame) warn_of_resting(placed.node);
    }
    return std::move(frames_);
  }

 private:
  NodeFrame place(std::size_t node, const NodeFrame& parent) {
    const auto found = tracks_.find(node);
    if (found == tracks_.end()) return resting(parent, local_matrix(document_, node));
    NodeTracks& tracks = found->second;
    LocalTransform local = local_transform(document_, node);
    settle(tracks, local);
    if (!tracks.translation && !tracks.rotation && !tracks.scale) return resting(parent, local.matrix());
    if (!is_rigid(node, tracks, parent.to_frame)) return resting(parent, local_matrix(document_, node));
    return moving(node, tracks, local, parent);
  }

  bool is_rigid(std::size_t node, const NodeTracks& tracks, const glm::dmat4& to_frame) const {
    const auto warn = [&](const char* what) {
      warnings_.add(node_name(document_, node) + ": " + what + " is not supported, it stays at rest");
    };
    if (tracks.scale) return warn("an animated scale"), false;
    const bool turns_unevenly = tracks.rotation && !keeps_angles(glm::dmat3(to_frame));
    if (turns_unevenly) warn("an animated rotation below an uneven scale");
    return !turns_unevenly;
  }

  static NodeFrame resting(const NodeFrame& parent, const glm::dmat4& local) {
    return {parent.frame, parent.to_frame * local};
  }

  // With A the constant way to the surrounding frame: A·T(t)·R(t)·S = T(A·t)·(P·R(t)·P⁻¹)·A'·S, where A' is
  // A's linear part and P its rotation. The first two move, the rest is constant again.
  NodeFrame moving(std::size_t node, NodeTracks& tracks, LocalTransform local, const NodeFrame& parent) {
    const glm::dmat3 linear(parent.to_frame);
    MovingFrame frame;
    frame.node = node;
    frame.parent = parent.frame;
    frame.joint.translation = carried(
        tracks.translation ? std::move(*tracks.translation) : resting_at(local.translation), parent.to_frame);
    if (tracks.rotation) {
      frame.joint.rotation = carried(std::move(*tracks.rotation), linear);
      local.rotation = {1, 0, 0, 0};
    }
    local.translation = glm::dvec3(0);
    return {add(std::move(frame)), glm::dmat4(linear) * local.matrix()};
  }

  std::size_t add(MovingFrame frame) {
    frame.key_count = frame.joint.translation.times.size() + frame.joint.rotation.times.size();
    frame.reach = reach_of(frame.joint.translation);
    if (frame.parent != world_frame) {
      frame.key_count += frames_.moving[frame.parent].key_count;
      frame.reach += frames_.moving[frame.parent].reach;
    }
    if (!(frame.reach <= farthest))
      document_.fail(node_name(document_, frame.node), "its animation moves it beyond 1e9 in the world",
                     "scale or move the scene");
    frames_.moving.push_back(std::move(frame));
    return frames_.moving.size() - 1;
  }

  void warn_of_resting(std::size_t node) const {
    const tinygltf::Node& source = document_.model.nodes[node];
    const auto warn = [&](const char* what) {
      warnings_.add(node_name(document_, node) + ": an animated " + what +
                    " is not supported, it stays at rest");
    };
    if (source.camera != -1) warn("camera");
    if (source.extensions.contains("KHR_lights_punctual")) warn("light");
  }

  const Document& document_;
  const std::vector<PlacedNode>& nodes_;
  Warnings& warnings_;
  std::map<std::size_t, NodeTracks> tracks_;
  Frames frames_;
};

}  // namespace

Motion Frames::motion(std::size_t frame) const {
  Motion motion;
  for (; frame != world_frame; frame = moving[frame].parent) motion.joints.push_back(moving[frame].joint);
  std::reverse(motion.joints.begin(), motion.joints.end());
  return motion;
}

Frames resting_frames(const std::vector<PlacedNode>& nodes) {
  Frames frames;
  for (const PlacedNode& placed : nodes) frames.of_nodes.push_back({world_frame, placed.to_world});
  return frames;
}

Frames moving_frames(const Document& document, const std::vector<PlacedNode>& nodes, KeyBudget& budget,
                     Warnings& warnings) {
  return FrameFinder(document, nodes, budget, warnings).find();
}

}  // namespace coppice::gltf
