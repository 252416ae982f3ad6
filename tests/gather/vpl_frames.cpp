// The VPL tree of an animation: what changes is found, and when the tree is built anew.
#include <doctest/doctest.h>

#include <algorithm>
#include <coppice/gather/group_lists.hpp>
#include <coppice/gather/vpl_frames.hpp>

#include "gather/vpls.hpp"
#include "support/generators.hpp"

using namespace coppice;

namespace {

bool same_trees(const VplTree& a, const VplTree& b) {
  const auto same = [](auto x, auto y) {
    return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size_bytes()) == 0);
  };
  return a.tree().light_of_leaf == b.tree().light_of_leaf && same(a.nodes(), b.nodes()) &&
         same(a.bounds(), b.bounds());
}

/// The same places under another light, some of them dark.
void relight(std::vector<VplNode>& vpls, Random& random) {
  for (VplNode& n : vpls) {
    const VplNode lit = support::any_vpl(random, n.position, n.normal);
    n.diffuse = lit.diffuse, n.specular = lit.specular, n.energy = lit.energy;
    n.lobe = lit.lobe, n.exponent = lit.exponent;
  }
}

void scramble(std::vector<VplNode>& vpls, Random& random) {
  const auto order = test_support::shuffled(random, std::uint32_t(vpls.size()));
  const auto before = vpls;
  for (std::size_t i = 0; i < vpls.size(); ++i) vpls[i].position = before[order[i]].position;
}

}  // namespace

TEST_CASE("the first frame builds the tree, and a frame like the last changes nothing") {
  Random random(1);
  const auto vpls = support::room_vpls(random, 300);
  VplFrames frames;
  const auto first = frames.update(vpls);
  CHECK((first.is_rebuilt && first.changed == 300));
  CHECK(same_trees(frames.tree(), VplTree(vpls)));
  CHECK(first.looseness == frames.tree().looseness());
  const auto second = frames.update(vpls);
  CHECK((!second.is_rebuilt && second.changed == 0));
  CHECK(second.looseness == first.looseness);
  CHECK(same_trees(frames.tree(), VplTree(vpls)));
}

TEST_CASE("the VPLs that differ in any bit are found, and the tree is what filtering anew would make it") {
  Random random(2);
  for (const VplFilter filter : {VplFilter::moments, VplFilter::uniform})
    for (const std::size_t count : {1u, 2u, 77u, 400u}) {
      auto vpls = support::room_vpls(random, count);
      VplFrames frames({.filter = filter});
      frames.update(vpls);
      for (int frame = 0; frame < 10; ++frame) {
        VplTree expected = frames.tree();
        std::size_t changed = 0;
        for (std::size_t i = random.below(20); i < count; i += 1 + random.below(40), ++changed)
          vpls[i].diffuse.z = std::nextafter(vpls[i].diffuse.z, 9.0f);
        const auto update = frames.update(vpls);
        CHECK((update.changed == changed && !update.is_rebuilt));
        expected.set(vpls);
        CHECK(same_trees(frames.tree(), expected));
        CHECK(std::memcmp(frames.leaves().data(), vpls.data(), count * sizeof(VplNode)) == 0);
      }
    }
}

TEST_CASE("light that changes alone does not make a tree anew") {
  Random random(3);
  auto vpls = support::room_vpls(random, 500);
  VplFrames frames;
  frames.update(vpls);
  for (int frame = 0; frame < 50; ++frame) {
    relight(vpls, random);
    VplTree expected = frames.tree();
    expected.set(vpls);
    const auto update = frames.update(vpls);
    CHECK((!update.is_rebuilt && update.changed > 400));
    CHECK(same_trees(frames.tree(), expected));
  }
  for (VplNode& n : vpls) n.diffuse = n.specular = vec3(0), n.energy = 0;
  const auto dark = frames.update(vpls);
  CHECK((!dark.is_rebuilt && dark.looseness == 0));
}

TEST_CASE("VPLs that change places make a tree anew, which is then kept") {
  Random random(4);
  auto vpls = support::room_vpls(random, 500);
  VplFrames frames;
  frames.update(vpls);
  scramble(vpls, random);
  const auto scrambled = frames.update(vpls);
  CHECK(scrambled.is_rebuilt);
  CHECK(same_trees(frames.tree(), VplTree(vpls)));
  CHECK(scrambled.looseness == frames.tree().looseness());
  CHECK(!frames.update(vpls).is_rebuilt);
}

TEST_CASE("VPLs that drift apart are built anew after some frames, not each") {
  Random random(5);
  auto vpls = support::room_vpls(random, 500);
  std::vector<vec3> ways;
  for (std::size_t i = 0; i < vpls.size(); ++i) ways.push_back(0.05f * random.direction());
  VplFrames frames;
  frames.update(vpls);
  int rebuilt = 0;
  for (int frame = 0; frame < 100; ++frame) {
    for (std::size_t i = 0; i < vpls.size(); ++i) vpls[i].position += ways[i];
    rebuilt += frames.update(vpls).is_rebuilt;
  }
  CHECK(rebuilt >= 1);  // measured: 3
  CHECK(rebuilt <= 20);
}

TEST_CASE("a share of 0 never builds anew, a share above 1 does as soon as anything is looser") {
  Random random(6);
  auto vpls = support::room_vpls(random, 200);
  VplFrames never({}, 0), eager({}, 1.01);
  never.update(vpls), eager.update(vpls);
  CHECK(eager.update(vpls).is_rebuilt);
  scramble(vpls, random);
  VplTree expected = never.tree();
  expected.set(vpls);
  CHECK(!never.update(vpls).is_rebuilt);
  CHECK(same_trees(never.tree(), expected));
}

TEST_CASE("another number of VPLs is another tree; none is one without leaves") {
  Random random(7);
  VplFrames frames;
  CHECK(frames.update({}).changed == 0);
  CHECK(frames.tree().leaf_count() == 0);
  for (const std::size_t count : {5u, 300u, 1u, 0u, 40u}) {
    const auto vpls = support::room_vpls(random, count);
    const auto update = frames.update(vpls);
    CHECK((update.is_rebuilt && update.changed == count));
    CHECK(same_trees(frames.tree(), VplTree(vpls)));
  }
}
