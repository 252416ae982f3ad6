// Cones in lobes: packings, cover, and the mean visibility that they give.
#include <doctest/doctest.h>

#include <coppice/core/random.hpp>
#include <coppice/sg/cones.hpp>

#include "lobe/tables.hpp"
#include "sg/brdf_slices.hpp"

using namespace sg_test;

namespace {

constexpr int counts[] = {1, 3, 7, 13, 19};

BrdfLobes lobes_of(const Slice& slice) {
  return slice.kind == BRDF_LAMBERT ? lambert_lobes(slice.viewer()) : slice.lobes();
}

struct Quality {
  double cover = 0;  ///< share of the lobe's energy that lies within a cone
  double error = 0;  ///< rms of the mean visibility by random discs that hide the light
};

/// Over the nodes: the slice times the weight, and the same of what the cones stand for; both sum to 1.
struct Weights {
  std::vector<SphereNode> nodes;
  std::vector<double> slice, cones;
  double cover = 0;
};

Weights weights_of(const Slice& slice, const LobeCones& cones) {
  Weights w;
  w.nodes = slice.kind == BRDF_LAMBERT ? reference::sphere_nodes({0, 0, 1}, 1, 60, 90) : slice.nodes(60, 60);
  std::erase_if(w.nodes, [](const SphereNode& n) { return n.direction.z <= 0; });
  w.cones.resize(w.nodes.size());
  double whole = 0;
  for (const SphereNode& n : w.nodes) {
    const BrdfTerms<double> t = slice.terms(n.direction);
    w.slice.push_back((slice.kind == BRDF_LAMBERT ? t.diffuse : t.specular + t.fresnel) * n.weight);
    whole += w.slice.back();
  }
  std::vector<bool> inside(w.nodes.size());
  for (int c = 0; c < cones.count; ++c) {
    std::vector<double> g;
    double sum = 1e-30;
    for (const SphereNode& n : w.nodes) {
      const double value = reference::gaussian(cones.shapes[std::size_t(c)], n.direction);
      if (value >= 0.5) inside[g.size()] = true;
      g.push_back(value * n.weight), sum += g.back();
    }
    for (std::size_t i = 0; i < g.size(); ++i)
      w.cones[i] += double(cones.shares[std::size_t(c)]) * g[i] / sum;
  }
  for (std::size_t i = 0; i < w.slice.size(); ++i) {
    w.slice[i] /= whole;
    if (inside[i]) w.cover += w.slice[i];
  }
  return w;
}

Quality quality_of(const Slice& slice, int count) {
  const Weights w = weights_of(slice, cones_of(lobes_of(slice), count));
  const bool wide = slice.kind == BRDF_LAMBERT;
  const float size = wide ? 2.0f : 4 * float(slice.alpha);
  Random random(17);
  double squares = 0;
  constexpr int discs = 120;
  for (int i = 0; i < discs; ++i) {
    const vec3 centre = normalize(vec3(slice.mirror()) + size * random.uniform() * random.direction());
    const double edge = std::cos(std::min(double(size * random.uniform()) * 0.7, 3.0));
    double exact = 0, seen = 0;
    for (std::size_t k = 0; k < w.nodes.size(); ++k)
      if (glm::dot(dvec3(centre), w.nodes[k].direction) <= edge) exact += w.slice[k], seen += w.cones[k];
    squares += (exact - seen) * (exact - seen);
  }
  return {w.cover, std::sqrt(squares / discs)};
}

const Slice slices[] = {{BRDF_LAMBERT, 1, 0.8}, {BRDF_PHONG, 0.5, 0.9},      {BRDF_PHONG, 0.2, 0.9},
                        {BRDF_PHONG, 0.2, 0.3}, {BRDF_GGX, 1, 0.9},          {BRDF_GGX, 0.6, 0.9},
                        {BRDF_GGX, 0.6, 0.3},   {BRDF_GGX, 0.3, 0.9},        {BRDF_GGX, 0.3, 0.3},
                        {BRDF_GGX, 0.1, 0.9},   {BRDF_GGX, 0.1, 0.3},        {BRDF_GGX, 0.02, 0.9},
                        {BRDF_WARD, 0.2, 0.6},  {BRDF_BLINN_PHONG, 0.2, 0.6}};

std::string name_of(const Slice& slice) {
  const char* names[] = {"Lambert", "GGX", "Phong", "Blinn-Phong", "Ward"};
  std::ostringstream text;
  text << names[slice.kind] << ", alpha " << slice.alpha << ", cosine " << slice.cosine;
  return text.str();
}

}  // namespace

TEST_CASE("packed circles do not overlap and stay in the disc, and each touches another or the edge") {
  for (const int count : counts) {
    const DiscPacking packing = disc_packing(count);
    REQUIRE(packing.count == count);
    for (int i = 0; i < count; ++i) {
      const vec2 a = packing.centres[std::size_t(i)];
      float nearest = 2 * (1 - length(a));
      CHECK(length(a) + packing.radius <= 1 + 1e-6f);
      for (int j = 0; j < count; ++j)
        if (j != i) nearest = std::min(nearest, length(a - packing.centres[std::size_t(j)]));
      CHECK(nearest >= 2 * packing.radius - 1e-6f);
      CHECK(nearest <= 2 * packing.radius + 0.02f);
    }
  }
}

TEST_CASE("a cone's Gaussian falls to a half at its edge") {
  for (const float angle : {1e-4f, 0.01f, 0.3f, 1.0f, 2.0f, 3.14159f}) {
    const SgShape g{vec3(0, 0, 1), sg_cone_sharpness(angle)};
    CHECK(sg_evaluate(g, vec3(std::sin(angle), 0, std::cos(angle))) == doctest::Approx(0.5).epsilon(1e-3));
  }
}

TEST_CASE("cones cover their lobe and give its mean visibility as near as stated") {
  const double columns[] = {1, 3, 7, 13, 19};
  lobe_test::Table table("cover / rms error of the visibility, by the number of cones", "lobe", columns);
  for (const Slice& slice : slices) {
    table.start_row(name_of(slice));
    for (const int count : counts) {
      const Quality q = quality_of(slice, count);
      table.add({q.cover, q.error});
      CAPTURE(name_of(slice));
      CAPTURE(count);
      CHECK(q.cover >= 0.45);
      CHECK(q.error <= (count < 7 ? 0.1 : 0.075));
    }
  }
  table.print();
}

TEST_CASE("cones lie above the horizon and share all of the lobe") {
  for (const uint kind : {BRDF_LAMBERT, BRDF_GGX, BRDF_PHONG, BRDF_BLINN_PHONG, BRDF_WARD})
    for (const double alpha : {1e-3, 0.03, 0.2, 1.0})
      for (const double cosine : {1.0, 0.7, 0.1, 1e-3})
        for (const int count : counts) {
          const LobeCones cones = cones_of(lobes_of({kind, alpha, cosine}), count);
          float sum = 0;
          REQUIRE(cones.count == count);
          for (int i = 0; i < count; ++i) {
            const SgShape& shape = cones.shapes[std::size_t(i)];
            CHECK(length(shape.axis) == doctest::Approx(1).epsilon(1e-5));
            CHECK(shape.axis.z > 0);
            CHECK(std::isfinite(shape.sharpness));
            CHECK(shape.sharpness >= 0.3f);
            CHECK(cones.shares[std::size_t(i)] >= 0);
            sum += cones.shares[std::size_t(i)];
          }
          CHECK(sum == doctest::Approx(1).epsilon(1e-5));
        }
}

TEST_CASE("Lambert's cones have equal shares of the cosine") {
  for (const int count : counts) {
    const LobeCones cones = cones_of(lambert_lobes(vec3(0, 0, 1)), count);
    for (int i = 0; i < count; ++i) {
      const SgShape& shape = cones.shapes[std::size_t(i)];
      const float area = 1.3862944f * pi / shape.sharpness * shape.axis.z;  // solid angle · cosine
      const float radius = disc_packing(count).radius;
      CHECK(area == doctest::Approx(pi * radius * radius).epsilon(count == 1 ? 1.1 : 1e-3));
    }
  }
}

TEST_CASE("cones of a lobe that is seen at a slant stretch along the plane of incidence") {
  const LobeEllipse ellipse = lobe_ellipse(Slice{BRDF_GGX, 0.1, 0.3}.lobes(), 0.03f);
  CHECK(ellipse.half_up > 1.5f * ellipse.half_out);
  const LobeEllipse round = lobe_ellipse(Slice{BRDF_GGX, 0.1, 1}.lobes(), 0.03f);
  CHECK(round.half_up == doctest::Approx(round.half_out).epsilon(0.02));
}
