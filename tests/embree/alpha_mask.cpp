#include <doctest/doctest.h>

#include <coppice/embree/tracer.hpp>
#include <limits>

using namespace coppice;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr vec3 toward_cards{0, 0, -1};

/// Two triangles that fill the unit square at depth z, their uv (0, 0) at the upper left.
void add_card(Scene& scene, float z, std::uint32_t material) {
  Mesh& mesh = scene.mesh;
  const auto first = std::uint32_t(mesh.positions.size());
  for (const vec2 corner : {vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 1)}) {
    mesh.positions.push_back({corner.x, corner.y, z});
    mesh.uvs.push_back({corner.x, 1 - corner.y});
  }
  mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
  mesh.materials.insert(mesh.materials.end(), {material, material});
}

/// 2 × 2 texels whose alpha is 0 at the upper right, `alpha` elsewhere.
Texture corner_hole(std::uint8_t alpha) {
  return {2, 2, true, Wrap::clamp, Wrap::clamp, {9, 9, 9, alpha, 9, 9, 9, 0, 9, 9, 9, alpha, 9, 9, 9, alpha}};
}

/// A card with a hole at its upper right in front (z = 1), a solid card behind (z = 0). Triangles 2 and 3 are
/// the solid ones; the masked ones come first, so that primitive ids and scene indices differ.
Scene card_with_hole(std::uint8_t texture_alpha = 255) {
  Scene scene;
  scene.materials.resize(2);
  scene.materials[1].alpha_mask = true;
  scene.materials[1].base_color_texture = 0;
  scene.textures = {corner_hole(texture_alpha)};
  add_card(scene, 1, 1);
  add_card(scene, 0, 0);
  return scene;
}

constexpr vec3 above_hole{0.8f, 0.9f, 2}, above_solid{0.2f, 0.3f, 2}, above_lower_right{0.9f, 0.2f, 2};

}  // namespace

TEST_CASE("A camera ray passes through a hole of the alpha mask to what lies behind") {
  const Scene scene = card_with_hole();
  const EmbreeTracer tracer(scene);
  const std::optional<Hit> through = tracer.closest(above_hole, toward_cards);
  REQUIRE(through);
  CHECK(through->t == doctest::Approx(2));
  CHECK(scene.mesh.materials[through->triangle] == 0);
  for (const vec3& origin : {above_solid, above_lower_right}) {
    const std::optional<Hit> stopped = tracer.closest(origin, toward_cards);
    REQUIRE(stopped);
    CHECK(stopped->t == doctest::Approx(1));
    CHECK(scene.mesh.materials[stopped->triangle] == 1);
  }
}

TEST_CASE("A shadow ray passes through a hole of the alpha mask from either side") {
  const Scene scene = card_with_hole();
  const EmbreeTracer tracer(scene);
  CHECK_FALSE(tracer.occluded(above_hole, toward_cards, 1.5f));
  CHECK(tracer.occluded(above_hole, toward_cards, infinity));  // the solid card
  CHECK(tracer.occluded(above_solid, toward_cards, 1.5f));
  CHECK_FALSE(tracer.occluded({0.8f, 0.9f, 0.5f}, {0, 0, 1}, infinity));
  CHECK(tracer.occluded({0.2f, 0.3f, 0.5f}, {0, 0, 1}, infinity));
}

TEST_CASE("Packets see the same holes as single rays") {
  const Scene scene = card_with_hole();
  const EmbreeTracer tracer(scene);
  ShadowPacket packet{};
  std::uint32_t expected = 0;
  for (std::size_t lane = 0; lane < 16; ++lane) {
    const vec3 origin((float(lane % 4) + 0.4f) / 4, (float(lane / 4) + 0.3f) / 4, 2);
    packet.origin_x[lane] = origin.x, packet.origin_y[lane] = origin.y, packet.origin_z[lane] = origin.z;
    packet.direction_z[lane] = -1;
    packet.t_max[lane] = 1.5f;
    if (tracer.occluded(origin, toward_cards, 1.5f)) expected |= 1u << lane;
  }
  CHECK(tracer.occluded(packet, 0xffff) == expected);
  CHECK(expected != 0);
  CHECK(expected != 0xffff);
  CHECK(tracer.occluded(packet, 0x0f0f) == (expected & 0x0f0f));
}

TEST_CASE("The alpha that meets the cutoff is the material's factor times the texture's") {
  Scene scene = card_with_hole(153);  // 0.6
  const auto blocked = [&] { return EmbreeTracer(scene).occluded(above_solid, toward_cards, 1.5f); };
  Material& material = scene.materials[1];
  CHECK(blocked());
  material.alpha = 0.7f;
  CHECK_FALSE(blocked());
  material.alpha_cutoff = 0.4f;
  CHECK(blocked());
  material.alpha_mask = false;  // opaque: alpha counts for nothing
  material.alpha = 0;
  CHECK(blocked());
}

TEST_CASE("Without a texture the alpha factor alone decides and alpha at the cutoff is solid") {
  Scene scene;
  scene.materials.resize(1);
  add_card(scene, 0, 0);
  Material& material = scene.materials[0];
  material.alpha_mask = true;
  const auto hit = [&] { return EmbreeTracer(scene).closest(above_solid, toward_cards).has_value(); };
  material.alpha = 0.5f;
  CHECK(hit());
  material.alpha = 0.49f;
  CHECK_FALSE(hit());
}

TEST_CASE("A mask keeps working after the tracer has moved") {
  const Scene scene = card_with_hole();
  EmbreeTracer first(scene);
  const EmbreeTracer moved = std::move(first);
  CHECK_FALSE(moved.occluded(above_hole, toward_cards, 1.5f));
  CHECK(moved.occluded(above_solid, toward_cards, 1.5f));
}
