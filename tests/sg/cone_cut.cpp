// Cones placed by a cut of light × BRDF, against the sum over every leaf.
#include "sg/skies.hpp"
//
#include <doctest/doctest.h>

#include <coppice/reference/cone_cut.hpp>
#include <coppice/sg/cone_cut.hpp>
#include <coppice/sg/lit_cones.hpp>
#include <functional>

#include "support/executors.hpp"

using namespace coppice;
using namespace sg_test;
using namespace test_support;

namespace {

constexpr auto everything = [](const glm::dvec3&) { return true; };

/// Light × BRDF of all leaves and peaks, in double.
glm::dvec3 dense(const ShadingPoint& p, const SkyLights& sky) {
  const FrameLighting& lighting = sky.lighting();
  glm::dvec3 sum = reference::ConeCutOfLeaves(lighting.nodes, lighting.ends).sums(p)[1].radiance;
  for (const SgLight& peak : sky.parts().peaks) sum += reference::reflected(p, peak, everything).radiance;
  return sum;
}

/// Pieces that are leaves.
support::LitTree every_leaf(std::uint32_t count, Random& random) {
  return support::random_lit_tree(count, count, 0, random);
}

/// The cones of a point over lights of which each is a piece.
void check_against_twin(const FrameLighting& frame, const ShadingPoint& p, const ConeCutOptions& options) {
  const ProductTree tree(frame, {});
  ConeCut cut(tree, options);
  const LitCones& lit = cut.place(p);
  const reference::ConeCutOfLeaves leaves(frame.nodes, frame.ends);
  auto expected = leaves.place(p, options.cones, double(options.negligible));
  auto cones = lit.cones;
  std::ranges::sort(cones, std::greater(), [](const LitCone& c) { return c.luminance; });
  std::ranges::sort(expected.cones, std::greater(),
                    [](const reference::ReflectedCone& c) { return c.sum.luminance; });
  REQUIRE(cones.size() == expected.cones.size());
  const double total = glm::length(leaves.sums(p)[1].radiance);
  CHECK(glm::length(glm::dvec3(lit.untraced) - expected.untraced) <= 1e-4 * total);
  for (std::size_t i = 0; i < cones.size(); ++i) {
    const reference::ReflectedCone& twin = expected.cones[i];
    CHECK(glm::length(glm::dvec3(cones[i].radiance) - twin.sum.radiance) < 1e-4 * total);
    CHECK(std::abs(double(cones[i].luminance) - twin.sum.luminance) < 1e-4 * total);
    const double apart = glm::length(glm::dvec3(cones[i].shape.axis) - twin.shape.axis);
    CHECK(apart * std::sqrt(std::min(twin.shape.sharpness, 1e4)) < 0.01);
    if (twin.shape.sharpness < 1e4)
      CHECK(std::abs(double(cones[i].shape.sharpness) / twin.shape.sharpness - 1) < 0.01);
    else
      CHECK(cones[i].shape.sharpness > 5e3f);
  }
}

ShadingPoint point_towards(const vec3& viewer) {
  ShadingPoint p{};
  p.normal = vec3(0, 1, 0), p.tangent = vec3(1, 0, 0), p.to_viewer = viewer;
  return p;
}

/// ∫ BRDF · cos over the lights' directions, about the mirror direction.
double albedo(const ShadingPoint& p, double width) {
  const vec3 mirror = 2 * dot(p.normal, p.to_viewer) * p.normal - p.to_viewer;
  double sum = 0;
  for (const auto& n : reference::sphere_nodes(glm::normalize(glm::dvec3(mirror)), width, 300, 200))
    sum += reference::reflected(p, glm::dvec3(n.weight), n.direction).radiance.y;
  return sum;
}

}  // namespace

TEST_CASE("where every leaf is a piece, cones are those of the slow twin") {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Random random(seed);
    const auto lit = every_leaf(256, random);
    for (const ShadingPoint& p : points_of_all_materials(2, random))
      for (const std::uint32_t cones : {1u, 2u, 5u, 10u}) {
        CAPTURE(p.brdf);
        check_against_twin(lit.frame, p, {.cones = cones, .negligible = 0});
        check_against_twin(lit.frame, p, {.cones = cones});
      }
  }
}

TEST_CASE("the light of all cones is the sum over all leaves and peaks, whatever the BRDF") {
  SkyLights sky({.lights = 4096, .pieces = 256});
  for (const bool has_lamps : {false, true}) {
    Random random(1);
    sky.take(some_map(random, 512, 256, has_lamps ? 3 : 0));
    const ProductTree tree(sky.lighting(), sky.parts().peaks);
    REQUIRE((tree.peak_count() > 0) == has_lamps);
    ConeCut cut(tree), fine(tree, {.lobe_tolerance = 1e-4f}), finest(tree, {.lobe_tolerance = 0});
    for (const auto* materials : {&support::wide_materials, &support::narrow_materials})
      for (std::size_t m = 0; m < materials->size(); ++m) {
        RelativeRms usual, finer, exact;
        for (const ShadingPoint& p :
             support::random_points(std::span(*materials).subspan(m, 1), 30, random)) {
          const glm::dvec3 expected = dense(p, sky);
          usual.add(cut.place(p).unoccluded(), expected);
          finer.add(fine.place(p).unoccluded(), expected);
          exact.add(finest.place(p).unoccluded(), expected);
        }
        CAPTURE(m);
        CAPTURE(has_lamps);
        const bool is_narrowest = materials == &support::narrow_materials && m == 0;  // GGX, alpha = 0.04
        CHECK(usual.value() < (is_narrowest ? 0.05 : 0.015));
        CHECK(finer.value() < (is_narrowest ? 0.02 : 0.01));
        CHECK(exact.value() < 0.01);
      }
  }
}

TEST_CASE("neither the number of cones nor what is negligible changes the light before visibility") {
  Random random(5);
  SkyLights sky({.lights = 1024, .pieces = 128});
  sky.take(some_map(random, 64, 32));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  for (const ShadingPoint& p : points_of_all_materials(2, random)) {
    const glm::dvec3 expected(ConeCut(tree, {.cones = 1, .negligible = 0}).place(p).unoccluded());
    for (const std::uint32_t cones : {1u, 3u, 7u, 64u, 4096u})
      for (const float negligible : {0.0f, 2e-3f, 0.1f, 1.0f}) {
        ConeCut cut(tree, {.cones = cones, .negligible = negligible});
        CHECK(apart(glm::dvec3(cut.place(p).unoccluded()), expected) < 1e-5);
      }
    CHECK(apart(glm::dvec3(ConeCut(tree).place_peaks(p).unoccluded()), expected) < 1e-5);
  }
}

TEST_CASE("there are no more cones than were asked for and one a peak") {
  Random random(6);
  SkyLights sky({.lights = 1024, .pieces = 128});
  sky.take(some_map(random, 64, 32, 6));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  REQUIRE(tree.peak_count() > 2);
  for (const ShadingPoint& p : points_of_all_materials(4, random))
    for (const std::uint32_t cones : {1u, 2u, 7u, 40u}) {
      ConeCut every(tree, {.cones = cones, .negligible = 0}), some(tree, {.cones = cones});
      const LitCones& lit = every.place(p);
      CHECK(lit.cones.size() <= cones + tree.peak_count());
      for (const LitCone& c : lit.cones) {
        CHECK(std::abs(length(c.shape.axis) - 1) < 1e-6f);
        CHECK(c.luminance > 0);
        CHECK(is_never_negative(c.radiance));
        CHECK(std::abs(luminance(c.radiance) - c.luminance) <= 1e-5f * c.luminance);
      }
      CHECK(some.place(p).cones.size() <= lit.cones.size());
      CHECK(every.place_peaks(p).cones.size() <= tree.peak_count());
    }
}

TEST_CASE("no cone gives less than what is negligible, and what is untraced is little") {
  Random random(7);
  SkyLights sky({.lights = 1024, .pieces = 128});
  sky.take(some_map(random, 64, 32, 6));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  ConeCut cut(tree, {.cones = 16, .negligible = 0.01f});
  for (const ShadingPoint& p : points_of_all_materials(4, random)) {
    const LitCones& lit = cut.place(p);
    const float total = luminance(lit.unoccluded());
    for (const LitCone& c : lit.cones) CHECK(c.luminance > 0.01f * total * 0.9999f);
    CHECK(luminance(lit.untraced) <= 0.01f * total * float(16 + tree.peak_count()));
  }
}

TEST_CASE("cones keep the mean direction of the light") {
  Random random(8);
  const auto lit = every_leaf(512, random);
  const ProductTree tree(lit.frame, {});
  const reference::ConeCutOfLeaves leaves(lit.frame.nodes, lit.frame.ends);
  for (const ShadingPoint& p : points_of_all_materials(2, random))
    for (const std::uint32_t cones : {1u, 7u, 30u}) {
      ConeCut cut(tree, {.cones = cones, .negligible = 0});
      glm::dvec3 moment(0);
      for (const LitCone& c : cut.place(p).cones)
        moment += double(c.luminance) * double(sg_mean_length(c.shape.sharpness)) * glm::dvec3(c.shape.axis);
      CHECK(apart(moment, leaves.sums(p)[1].moment) < 1e-4);
    }
}

TEST_CASE("in a furnace a plane shines with its albedo") {
  SkyLights sky({.lights = 32768, .pieces = 256});
  sky.take(Image(64, 32, vec3(1)));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  REQUIRE(tree.peak_count() == 0);
  ConeCut cut(tree), fine(tree, {.lobe_tolerance = 1e-5f});
  for (const float height : {1.0f, 0.7f, 0.3f}) {
    ShadingPoint p = point_towards(normalize(vec3(std::sqrt(1 - height * height), height, 0)));
    set_lambert(p, vec3(1));
    CHECK(std::abs(cut.place(p).unoccluded().y - 1) < 0.005f);
    p.brdf = BRDF_GGX, p.diffuse = vec3(0), p.specular = p.fresnel = vec3(1);
    for (const float alpha : {0.05f, 0.2f, 0.5f, 1.0f}) {
      p.alpha_x = p.alpha_y = alpha;
      const double expected = albedo(p, double(alpha));
      CAPTURE(alpha);
      CAPTURE(height);
      CHECK(std::abs(double(cut.place(p).unoccluded().y) / expected - 1) < (alpha < 0.1f ? 0.05 : 0.02));
      CHECK(std::abs(double(fine.place(p).unoccluded().y) / expected - 1) < 0.015);
    }
  }
}

TEST_CASE("environment and point turned together leave the light, and turn the cones") {
  Random random(10);
  SkyLights sky({.lights = 1024, .pieces = 128});
  sky.take(some_map(random, 64, 32));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  ConeCut cut(tree), other(tree);
  for (const ShadingPoint& p : points_of_all_materials(2, random))
    for (const float rotation : {0.4f, 2.5f, -1.0f}) {
      const MapFrame turn(rotation);
      ShadingPoint turned = p;  // as it stands in the world under the turned map
      for (vec3 ShadingPoint::*d : {&ShadingPoint::normal, &ShadingPoint::tangent, &ShadingPoint::to_viewer})
        turned.*d = turn.to_world(p.*d);
      const LitCones &a = cut.place(p), &b = other.place(turn.to_map(turned));
      CHECK(apart(glm::dvec3(b.unoccluded()), glm::dvec3(a.unoccluded())) < 1e-4);
      REQUIRE(a.cones.size() == b.cones.size());
      const float total = luminance(a.unoccluded());
      for (std::size_t i = 0; i < a.cones.size(); ++i)
        CHECK(length(a.cones[i].radiance - b.cones[i].radiance) < 1e-4f * total);
    }
}

TEST_CASE("a map turned by whole texels shines nearly the same on a turned point") {
  Random random(11);
  const Image map = some_map(random, 64, 32);
  Image shifted(64, 32);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) shifted.at((x + 64 - 9) % 64, y) = map.at(x, y);
  const MapFrame turn(2 * pi * 9 / 64);
  SkyLights still({.lights = 8192, .pieces = 512}), moved({.lights = 8192, .pieces = 512});
  still.take(map), moved.take(shifted);
  const ProductTree still_tree(still.lighting(), still.parts().peaks),
      moved_tree(moved.lighting(), moved.parts().peaks);
  ConeCut a(still_tree), b(moved_tree);
  Deviation deviation;
  for (const ShadingPoint& p : points_of_all_materials(4, random)) {
    ShadingPoint turned = p;
    for (vec3 ShadingPoint::*d : {&ShadingPoint::normal, &ShadingPoint::tangent, &ShadingPoint::to_viewer})
      turned.*d = turn.to_world(p.*d);
    deviation.add(apart(glm::dvec3(b.place(turned).unoccluded()), glm::dvec3(a.place(p).unoccluded())));
  }
  CHECK(deviation.rms() < 0.005);
  CHECK(deviation.most < 0.02);
}

TEST_CASE("one texel is one cone that points at it and gives its light") {
  Random random(12);
  SkyLights sky({.lights = 1024, .pieces = 64});
  Image map(1024, 512);
  map.at(300, 120) = vec3(4e5f, 3e5f, 2e5f);
  sky.take(map);
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  REQUIRE(tree.peak_count() == 1);
  const vec3 towards = texel_direction(300, 120, 1024, 512);
  const glm::dvec3 power = sg_test::energy_of(map);
  ConeCut cut(tree);
  int lit_points = 0;
  Deviation deviation;
  for (const ShadingPoint& p : points_of_all_materials(20, random)) {
    const glm::dvec3 expected = reference::reflected(p, power, glm::normalize(glm::dvec3(towards))).radiance;
    const LitCones& lit = cut.place(p);
    if (glm::length(expected) < 1e-9) continue;
    ++lit_points;
    REQUIRE(lit.cones.size() == 1);
    CHECK(lit.untraced == vec3(0));
    CHECK(length(lit.cones[0].shape.axis - towards) < 1e-5f);
    CHECK(lit.cones[0].shape.sharpness > 1e5f);
    deviation.add(apart(glm::dvec3(lit.cones[0].radiance), expected));
  }
  CHECK(lit_points > 50);
  CHECK(deviation.rms() < 1e-3);
  CHECK(deviation.most < 5e-3);
}

TEST_CASE("as a light grows sharp, its light becomes that of a point") {
  Random random(13);
  const FrameLighting nothing;
  const auto points = points_of_all_materials(4, random);
  const auto worst = [&](float sharpness) {
    Random axes(14);
    Deviation deviation;
    for (const ShadingPoint& p : points) {
      const vec3 axis = normalize(axes.direction() + p.normal);
      const std::vector<SgLight> light{sg_light_of_energy({axis, sharpness}, glm::dvec3(3, 2, 1))};
      const ProductTree tree(nothing, light);
      ConeCut cut(tree);
      const glm::dvec3 expected =
          reference::reflected(p, glm::dvec3(3, 2, 1), glm::normalize(glm::dvec3(axis))).radiance;
      deviation.add(apart(glm::dvec3(cut.place(p).unoccluded()), expected));
      for (const LitCone& c : cut.place(p).cones) CHECK(length(c.shape.axis - axis) < 1e-6f);
    }
    return deviation.most;
  };
  CHECK(worst(1e5f) < 0.1 * worst(1e3f));
  CHECK(worst(1e7f) < 0.1 * worst(1e5f));
  CHECK(worst(1e9f) < 1e-5);
}

TEST_CASE("a sun of 1e5 times the sky has a cone of its own where it shines") {
  Random random(15);
  SkyLights sky({.lights = 1024, .pieces = 64});
  Image map(512, 256, vec3(1));
  map.at(100, 60) = vec3(1e5f);
  sky.take(map);
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  const vec3 sun = texel_direction(100, 60, 512, 256);
  ConeCut cut(tree);
  RelativeRms all;
  for (const ShadingPoint& p : points_of_all_materials(10, random)) {
    const LitCones& lit = cut.place(p);
    const glm::dvec3 expected = dense(p, sky);
    CHECK(apart(glm::dvec3(lit.unoccluded()), expected) < 0.1);
    all.add(lit.unoccluded(), expected);
    const bool is_aimed =
        std::ranges::any_of(lit.cones, [&](const LitCone& c) { return length(c.shape.axis - sun) < 1e-4f; });
    if (dot(p.normal, sun) > 0.1f && p.diffuse != vec3(0)) CHECK(is_aimed);
    if (dot(p.normal, sun) < 0) CHECK_FALSE(is_aimed);
  }
  CHECK(all.value() < 0.01);
}

TEST_CASE("a black map gives no cones and no light; a map of one texel and one of 1e30 no NaN") {
  Random random(16);
  SkyLights sky({.lights = 1024, .pieces = 64});
  const auto points = points_of_all_materials(3, random);
  sky.take(Image(16, 8));
  const ProductTree black(sky.lighting(), sky.parts().peaks);
  for (const ShadingPoint& p : points) {
    ConeCut cut(black);
    CHECK(cut.place(p).cones.empty());
    CHECK(cut.place(p).untraced == vec3(0));
    CHECK(cut.place_peaks(p).unoccluded() == vec3(0));
  }
  sky.take(Image(1, 1, vec3(1)));
  const ProductTree one(sky.lighting(), sky.parts().peaks);
  for (const ShadingPoint& p : points) {
    CHECK(is_never_negative(ConeCut(one).place(p).unoccluded()));
    CHECK(apart(glm::dvec3(ConeCut(one).place(p).unoccluded()), dense(p, sky)) < 0.1);
  }
  Image huge(16, 8, vec3(1e20f));
  huge.at(3, 2) = vec3(1e30f);
  sky.take(huge);
  const ProductTree bright(sky.lighting(), sky.parts().peaks);
  for (const ShadingPoint& p : points) {
    ConeCut cut(bright);
    const LitCones& lit = cut.place(p);
    CHECK(is_never_negative(lit.untraced));
    CHECK(lit.unoccluded().x > 0);
    for (const LitCone& c : lit.cones) {
      CHECK(is_never_negative(c.radiance));
      CHECK((is_finite(c.shape.axis) && c.shape.sharpness >= 0 && std::isfinite(c.shape.sharpness)));
    }
  }
}

TEST_CASE("light of any strength has the same cones") {
  Random random(17);
  SkyLights sky({.lights = 1024, .pieces = 64});
  const Image map = some_map(random, 16, 8);
  sky.take(map);
  const SkyLights usual = sky;
  const ProductTree tree(usual.lighting(), usual.parts().peaks);
  const auto points = points_of_all_materials(2, random);
  for (const float scale : {0x1p-70f, 0x1p70f}) {
    CAPTURE(scale);
    Image scaled = map;
    for (vec3& texel : scaled.pixels) texel *= scale;
    sky.take(scaled);
    const ProductTree other(sky.lighting(), sky.parts().peaks);
    for (const ShadingPoint& p : points) {
      ConeCut a(tree), b(other);
      const LitCones &x = a.place(p), &y = b.place(p);
      REQUIRE(x.cones.size() == y.cones.size());
      for (std::size_t i = 0; i < x.cones.size(); ++i) {
        CHECK(length(x.cones[i].shape.axis - y.cones[i].shape.axis) < 1e-4f);
        CHECK(std::abs(y.cones[i].luminance / scale - x.cones[i].luminance) <= 1e-4f * x.cones[i].luminance);
      }
    }
  }
}

TEST_CASE("black materials, no lights and no points ask for nothing") {
  Random random(18);
  SkyLights sky({.lights = 1024, .pieces = 64});
  sky.take(some_map(random, 16, 8));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  const FrameLighting nothing;
  const ProductTree empty(nothing, {});
  for (ShadingPoint p : points_of_all_materials(2, random)) {
    ConeCut dark(empty);
    CHECK(dark.place(p).cones.empty());
    CHECK(dark.place(p).unoccluded() == vec3(0));
    p.diffuse = p.specular = p.fresnel = vec3(0);
    ConeCut cut(tree);
    CHECK(cut.place(p).cones.empty());
    CHECK(cut.place(p).unoccluded() == vec3(0));
    CHECK(cut.place_peaks(p).cones.empty());
  }
  struct Placer {
    ConeCut cut;
    const LitCones& place(std::size_t) { return cut.place(ShadingPoint{}); }
  };
  CHECK(place_cones(
            {}, [&] { return Placer{ConeCut(tree)}; }, Serial())
            .cones.empty());
}

TEST_CASE("what was placed before and how threads split points changes no bit") {
  Random random(19);
  SkyLights sky({.lights = 1024, .pieces = 128});
  sky.take(some_map(random, 64, 32));
  const ProductTree tree(sky.lighting(), sky.parts().peaks);
  const auto points = points_of_all_materials(60, random);
  struct Placer {
    ConeCut cut;
    std::span<const ShadingPoint> points;
    const LitCones& place(std::size_t i) { return cut.place(points[i]); }
  };
  const auto place = [&](const auto& executor) {
    return place_cones(
        std::vector<ConeReceiver>(points.size()),
        [&] {
          return Placer{ConeCut(tree), points};
        },
        executor);
  };
  const ConeBatch serial = place(Serial());
  REQUIRE(points.size() > 512);
  const auto check = [&](const ConeBatch& other) {
    CHECK(other.untraced == serial.untraced);
    CHECK(other.clusters == serial.clusters);
    REQUIRE(other.cones.size() == serial.cones.size());
    for (std::size_t c = 0; c < serial.cones.size(); ++c)
      REQUIRE((other.cones[c].radiance == serial.cones[c].radiance &&
               other.shapes[c].axis == serial.shapes[c].axis &&
               other.shapes[c].sharpness == serial.shapes[c].sharpness));
  };
  check(place(support::Backwards()));
  check(place(support::TwoThreads()));
}
