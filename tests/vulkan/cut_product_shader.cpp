// Products of cuts on the device against multiply_by_fields of the CPU, and what is shaded by them.
#include <doctest/doctest.h>

#include <coppice/light/directions.hpp>
#include <coppice/relight/shade_faces.hpp>
#include <coppice/tree/build.hpp>
#include <coppice/vulkan/cut_product_shader.hpp>
#include <coppice/vulkan/cut_shader.hpp>
#include <cstdlib>
#include <support/occluders.hpp>

#include "random_input.hpp"
#include "shaded.hpp"

using namespace coppice;
using namespace coppice::test;

namespace {

using Cuts = MaskedCuts<std::uint8_t>;

vec3 random_position(Random& random) {
  return {3 * random.uniform() - 1, 3 * random.uniform() - 1, 3 * random.uniform() - 1};
}

/// Values of which a quarter is 0 and a quarter 255, as those of visibility are.
Cuts random_cuts(Random& random, std::uint32_t leaf_count, std::uint32_t granule_log2, std::uint32_t count) {
  Cuts cuts(leaf_count, granule_log2);
  for (std::uint32_t i = 0; i < count; ++i) {
    Cut<std::uint8_t> cut;
    split(random, 0, leaf_count, 1u << granule_log2, cut.ends);
    for (std::size_t k = 0; k < cut.ends.size(); ++k) {
      const std::uint32_t kind = random.below(4);
      cut.values.push_back(kind == 0 ? 0 : kind == 1 ? 255 : std::uint8_t(random.below(256)));
    }
    cuts.append(cut, random_horizon(random));
  }
  return cuts;
}

/// Receivers, and fields in their places with the blends of their cuts.
class FieldScene {
 public:
  FieldScene(const Cuts& cuts, std::vector<ShadowField> fields, std::vector<vec3> positions,
             std::span<const std::uint8_t> wanted, std::span<const RigidTransform> to_world)
      : cuts_(cuts), fields_(std::move(fields)) {
    std::vector<std::vector<std::uint8_t>> used;
    for (std::size_t k = 0; k < fields_.size(); ++k) {
      placed_.push_back({&fields_[k], to_world[k].inverse(), fields_[k].cuts});
      used.emplace_back(fields_[k].cuts.size(), std::uint8_t{0});
    }
    blends_.emplace(placed_, positions, wanted, used, Serial());
  }

  FieldScene(const FieldScene&) = delete;
  FieldScene& operator=(const FieldScene&) = delete;

  const Cuts& cuts() const { return cuts_; }
  Cuts by_cpu() const { return multiply_by_fields(cuts_, *blends_, placed_, Serial(), &shadowed_); }
  DeviceCuts by(CutProductShader& shader) const { return shader.multiply(*blends_, placed_).cuts; }
  DeviceCuts by_device(VulkanDevice& device) const {
    CutProductShader shader(device, cuts_);
    return by(shader);
  }
  std::size_t shadowed() const { return shadowed_; }  ///< as by_cpu() found

 private:
  Cuts cuts_;
  std::vector<ShadowField> fields_;
  std::vector<PlacedField> placed_;
  std::optional<FieldBlends> blends_;
  mutable std::size_t shadowed_ = 0;
};

/// Fields around the origin of which the first is on shells, so that receivers may be beyond it.
FieldScene random_scene(std::uint32_t leaf_count, std::uint32_t granule_log2, std::size_t field_count,
                        std::uint64_t seed) {
  Random random(seed);
  const auto cuts = random_cuts(random, leaf_count, granule_log2, 200);
  std::vector<ShadowField> fields;
  for (std::size_t k = 0; k < field_count; ++k) {
    const FieldSamples samples = k == 0 ? FieldSamples(ShellSamples(vec3(0), 0.2f, 1.5f, 1, 3))
                                        : FieldSamples(GridSamples(vec3(-1), vec3(1), 0.7f));
    const auto count = std::uint32_t(positions_of(samples).size());
    fields.push_back(
        {samples, random_cuts(random, leaf_count, granule_log2, count), std::vector<std::uint8_t>(count, 0)});
  }
  std::vector<vec3> positions;
  std::vector<std::uint8_t> wanted;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    positions.push_back(random_position(random));
    wanted.push_back(random.below(10) > 0);
  }
  return {cuts, std::move(fields), std::move(positions), wanted, std::vector<RigidTransform>(field_count)};
}

bool same_horizons(const Cuts& a, const Cuts& b) {
  return std::ranges::equal(a.horizons(), b.horizons(), [](const auto& x, const auto& y) {
    return x.normal == y.normal && x.cosine == y.cosine;
  });
}

/// A CPU that fuses products with sums may round a value to the level beside it.
void check_same_cuts(const Cuts& device, const Cuts& cpu) {
  CHECK(std::ranges::equal(device.masks(), cpu.masks()));
  CHECK(same_horizons(device, cpu));
  REQUIRE(device.values().size() == cpu.values().size());
  std::size_t different = 0;
  int largest = 0;
  for (std::size_t i = 0; i < cpu.values().size(); ++i) {
    const int off = std::abs(int(device.values()[i]) - int(cpu.values()[i]));
    largest = std::max(largest, off);
    different += off != 0;
  }
  CHECK(largest <= 1);
  CHECK(different <= cpu.values().size() / 10'000);
}

/// A ball that casts shadows on receivers in a plane under a sky of 512 lights.
class BallScene {
 public:
  BallScene() : directions_(even_directions(512, 3)) {
    std::vector<LightSample> samples;
    for (const vec3& d : directions_) samples.push_back({d, vec3(0)});
    tree_ = build_tree(GeometricMetric(samples));
    Random random(5);
    for (int i = 0; i < 300; ++i)
      positions_.push_back({4 * random.uniform() - 2, 0, 4 * random.uniform() - 2});
    const support::SphereOccluder ball{{{vec3(0), 0.4f}}};
    const DirectionPackets lights(leaf_directions(tree_, directions_));
    const FieldSamples samples_around = ShellSamples(vec3(0), 0.42f, 4, 1, 6);
    field_.emplace(precompute_field(ball, tree_, lights, samples_around, {.sigma = 1}, Serial()));
    cuts_ = random_cuts(random, tree_.leaf_count(), field_->cuts.granule_log2(), 300);
  }

  FieldScene with_ball_at(const vec3& centre) const {
    const RigidTransform to_world{glm::quat(1, 0, 0, 0), centre};
    const std::vector<std::uint8_t> all(positions_.size(), 1);
    return {cuts_, {*field_}, positions_, all, std::span(&to_world, 1)};
  }

  const Cuts& cuts() const { return cuts_; }

  /// The sky on the tree, and points between any three of the receivers.
  RandomInput input() const {
    RandomInput input = random_input({.leaf_count = tree_.leaf_count(),
                                      .granule_log2 = cuts_.granule_log2(),
                                      .receiver_count = 300,
                                      .face_count = 100,
                                      .point_count = 1000});
    std::vector<CellLight> lights;
    for (const vec3& d : directions_) lights.push_back({vec3(1.0f, 1.5f, 2.0f) * (1.2f + d.y), 0.02f});
    input.frame = light_frame(tree_, lights, directions_, 100, cuts_.granule_log2());
    input.cuts = cuts_;
    return input;
  }

 private:
  std::vector<vec3> directions_;
  LightTree tree_;
  std::vector<vec3> positions_;
  std::optional<ShadowField> field_;
  Cuts cuts_;
};

Shaded by_cpu(const RandomInput& input, const Cuts& cuts, const LobeOptions& lobes) {
  Shaded shaded(input.buffer.points.size());
  shade_faces(input.buffer, cuts, input.frame, lobes, 0, input.buffer.faces.size(), shaded.radiance,
              shaded.clusters);
  return shaded;
}

Shaded by_device(CutShader& shader, const RandomInput& input, const LobeOptions& lobes) {
  Shaded shaded(input.buffer.points.size());
  shaded.radiance = shader.shade(input.frame.nodes, input.frame.mask, lobes, shaded.clusters).radiance;
  return shaded;
}

}  // namespace

TEST_CASE("cuts come back from the device as they were") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(3);
  const auto cuts = random_cuts(random, 1024, 2, 50);
  const DeviceCuts stored(device, cuts);
  CHECK(stored.size() == 50);
  const auto back = stored.download();
  CHECK(back.leaf_count() == 1024);
  CHECK(back.granule_log2() == 2);
  CHECK(std::ranges::equal(back.masks(), cuts.masks()));
  CHECK(std::ranges::equal(back.values(), cuts.values()));
  CHECK(same_horizons(back, cuts));
}

TEST_CASE("products of random cuts are those of the CPU, for every granule, tree size and number of fields") {
  if (!has_device()) return;
  VulkanDevice device;
  for (const std::uint32_t leaf_count : {1u, 32u, 1024u, 4096u})
    for (std::uint32_t granule_log2 = 0; granule_log2 <= 3 && 1u << granule_log2 <= leaf_count;
         ++granule_log2)
      for (const std::size_t field_count : {1u, 3u}) {
        CAPTURE(leaf_count);
        CAPTURE(granule_log2);
        CAPTURE(field_count);
        const auto scene = random_scene(leaf_count, granule_log2, field_count, leaf_count + granule_log2);
        const Cuts cpu = scene.by_cpu();
        CHECK(scene.shadowed() > 50);
        check_same_cuts(scene.by_device(device).download(), cpu);
      }
}

TEST_CASE("without fields a product is what it was, and without receivers it is empty") {
  if (!has_device()) return;
  VulkanDevice device;
  const auto scene = random_scene(256, 1, 0, 9);
  check_same_cuts(scene.by_device(device).download(), scene.cuts());
  const FieldScene nobody(Cuts(256, 1), {}, {}, {}, {});
  CHECK(nobody.by_device(device).size() == 0);
  CHECK(nobody.by_device(device).download().size() == 0);
}

TEST_CASE("a field that is dark hides everything, one that is clear nothing") {
  if (!has_device()) return;
  VulkanDevice device;
  Random random(4);
  const auto cuts = random_cuts(random, 64, 0, 20);
  for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{255}}) {
    const FieldSamples samples = GridSamples(vec3(-1), vec3(1), 2);
    Cuts of_field(64, 0);
    const std::vector<std::uint32_t> ends{32, 64};
    const std::vector<std::uint8_t> values{value, value};
    for (int i = 0; i < 8; ++i) of_field.append({ends, values});
    const FieldScene scene(cuts, {{samples, of_field, std::vector<std::uint8_t>(8, 0)}},
                           std::vector<vec3>(20, vec3(0.3f)), std::vector<std::uint8_t>(20, 1),
                           std::vector<RigidTransform>(1));
    const Cuts product = scene.by_device(device).download();
    check_same_cuts(product, scene.by_cpu());
    for (std::size_t i = 0; i < 20; ++i)
      for (std::uint32_t leaf = 0; leaf < 64; ++leaf) {
        const auto at = [leaf](const Cut<std::uint8_t>& cut) {
          return cut.values[std::size_t(std::ranges::upper_bound(cut.ends, leaf) - cut.ends.begin())];
        };
        CHECK(at(product.unpack(i)) == (value == 0 ? 0 : at(cuts.unpack(i))));
      }
  }
}

TEST_CASE("points in the shadow of a ball that moves are shaded as on the CPU") {
  if (!has_device()) return;
  VulkanDevice device;
  const BallScene scene;
  const RandomInput input = scene.input();
  CutProductShader product(device, scene.cuts());
  CutShader shader(device, input.view());
  const auto unshadowed = by_device(shader, input, {}).radiance;
  std::vector<vec3> before = unshadowed;
  for (const vec3& centre : {vec3(0, 0.5f, 0), vec3(1, 0.6f, -0.5f)}) {
    const FieldScene now = scene.with_ball_at(centre);
    const Cuts cuts = now.by_cpu();
    CHECK(now.shadowed() > 50);
    DeviceCuts on_device = now.by(product);
    check_same_cuts(on_device.download(), cuts);
    shader.set_cuts(std::move(on_device));
    for (const Lobes lobes : {Lobes::sampled, Lobes::filtered, Lobes::refined})
      check_alike(by_device(shader, input, {lobes, 1e-3f}), by_cpu(input, cuts, {lobes, 1e-3f}));
    const auto after = by_device(shader, input, {}).radiance;
    CHECK(relative_rms(after, before) > 1e-2);
    before = after;
  }
  shader.set_cuts(DeviceCuts(device, scene.cuts()));
  CHECK(by_device(shader, input, {}).radiance == unshadowed);
}

TEST_CASE("a shader without cuts of its own shades by those that it is given") {
  if (!has_device()) return;
  VulkanDevice device;
  const RandomInput input = random_input({.leaf_count = 128, .granule_log2 = 1});
  CutShader whole(device, input.view());
  CutShadeInput points = input.view();
  points.visibility_masks = points.first_value = {};
  points.values = {};
  points.horizons = {};
  CutShader shader(device, points);
  shader.set_cuts(DeviceCuts(device, input.cuts));
  CHECK(by_device(shader, input, {}).radiance == by_device(whole, input, {}).radiance);
}

TEST_CASE("the validation layer has nothing to say of products") {
  if (!has_device({.validation = true})) return;
  VulkanDevice device({.validation = true});
  const auto scene = random_scene(64, 0, 2, 1);
  check_same_cuts(scene.by_device(device).download(), scene.by_cpu());
  for (const std::string& message : device.validation_messages()) FAIL_CHECK(message);
}
