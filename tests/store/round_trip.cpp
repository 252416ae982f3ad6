// What is written comes back.
#include "files.hpp"
#include "visibilities.hpp"

using namespace store_test;

namespace {

template <Quantised Value>
void check_round_trip(const StoredVisibility<Value>& visibility) {
  const Folder folder;
  write_store(folder / "a.h5", visibility);
  check_same(read_store<Value>(folder / "a.h5"), visibility);
  CHECK(read_settings(folder / "a.h5") == visibility.settings);
  CHECK(folder.count() == 1);
}

}  // namespace

TEST_CASE("visibility comes back as it was stored, in 8 and in 16 bits, under both weights") {
  const ReceiverMesh mesh = refined_mesh(300);
  REQUIRE(mesh.corners().size() > 100);
  for (const CutWeight weight : {CutWeight::uniform, CutWeight::cosine}) {
    check_round_trip(random_visibility<std::uint8_t>(1, 1000, mesh, 2, weight));
    check_round_trip(random_visibility<std::uint16_t>(2, 1000, mesh, 0, weight));
  }
}

TEST_CASE("more receivers than one block holds come back") {
  Random random(3);
  StoredVisibility<std::uint8_t> v;
  v.tree = random_tree(random, 64);
  for (int i = 0; i < 64; ++i) v.lights.push_back(vec4(random.direction(), 0));
  add_receivers(v, random, 2500, 0);
  check_round_trip(v);
}

TEST_CASE("stores of next to nothing come back") {
  check_round_trip(StoredVisibility<std::uint8_t>());
  check_round_trip(StoredVisibility<std::uint16_t>());
  StoredVisibility<std::uint8_t> v;
  v.settings = {{"", ""}, {"many\nlines", std::string(100000, 'x')}};
  check_round_trip(v);  // settings alone
  Random random(4);
  v.tree = random_tree(random, 1);
  v.lights = {vec4(0, 1, 0, 0)};
  v.cuts = MaskedCuts<std::uint8_t>(1, 0);
  check_round_trip(v);  // no receiver
  add_receivers(v, random, 1, 0);
  check_round_trip(v);  // one
}

TEST_CASE("cuts of a tree without lights come back") {
  StoredVisibility<std::uint8_t> v;
  Random random(5);
  add_receivers(v, random, 3, 0);
  check_round_trip(v);
}

TEST_CASE("a mesh of backs, and one whose corners are no middles, come back") {
  Mesh mesh;
  support::add_ground(mesh, 1);
  const std::vector<SidedTriangle> sides{{0, true}, {1, false}, {1, true}};
  ReceiverMesh receivers(mesh, sides);
  const ReceiverMesh::Face face = receivers.faces()[0];
  const std::uint32_t moved = receivers.add_corner({vec3(7), vec3(0, 1, 0)});
  const vec2 middle = 0.5f * (face.uv[0] + face.uv[1]);
  const std::vector<ReceiverMesh::Face> halves{
      {{face.corners.x, moved, face.corners.z}, {face.uv[0], middle, face.uv[2]}, face.normal, face.triangle},
      {{moved, face.corners.y, face.corners.z},
       {middle, face.uv[1], face.uv[2]},
       face.normal,
       face.triangle}};
  receivers.subdivide(0, halves);
  check_round_trip(random_visibility<std::uint8_t>(6, 10, receivers, 0));
}

TEST_CASE("a face that is split elsewhere than at middles is refused") {
  Mesh mesh;
  support::add_ground(mesh, 1);
  ReceiverMesh receivers(mesh, relight_test::all_fronts(mesh));
  ReceiverMesh::Face child = receivers.faces()[0];
  child.uv[1] = vec2(0.7f, 0.1f);
  receivers.subdivide(0, {&child, 1});
  const Folder folder;
  const auto v = random_visibility<std::uint8_t>(7, 10, receivers, 0);
  CHECK(contains(refusal(folder / "a.h5", [&] { write_store(folder / "a.h5", v); }), "split elsewhere"));
  ReceiverMesh copies(mesh, relight_test::all_fronts(mesh));
  const std::vector<ReceiverMesh::Face> twice(2, copies.faces()[0]);
  copies.subdivide(0, twice);
  const auto w = random_visibility<std::uint8_t>(7, 10, copies, 0);
  CHECK(contains(refusal(folder / "a.h5", [&] { write_store(folder / "a.h5", w); }), "split elsewhere"));
  CHECK(folder.count() == 0);
}

TEST_CASE("what does not belong together is refused before it is written") {
  const Folder folder;
  const auto refused = [&](auto&& spoil) {
    auto v = small_visibility();
    spoil(v);
    const std::string message = refusal(folder / "a.h5", [&] { write_store(folder / "a.h5", v); });
    CHECK(folder.count() == 0);
    return message;
  };
  CHECK(contains(refused([](auto& v) { v.lights.pop_back(); }), "the tree"));
  CHECK(contains(refused([](auto& v) { v.receivers.pop_back(); }), "one receiver a corner"));
  CHECK(contains(refused([](auto& v) { v.cuts = {}; }), "one cut a receiver"));
  CHECK(contains(refused([](auto& v) { v.scales.pop_back(); }), "one scale a receiver"));
  CHECK(contains(refused([](auto& v) { v.weight = CutWeight::uniform; }), "horizon"));
  CHECK(contains(refused([](auto& v) { v.scales[1] = std::numeric_limits<float>::infinity(); }),
                 "receivers/scale"));
  CHECK(contains(refused([](auto& v) { v.receivers[0].position.y = std::nanf(""); }), "receivers/position"));
  CHECK(contains(refused([](auto& v) { v.settings[0].key += '\0'; }), "NUL"));
}

TEST_CASE("equal visibility gives equal files") {
  const Folder folder;
  write_store(folder / "a.h5", small_visibility());
  write_store(folder / "b.h5", small_visibility());
  CHECK(get(folder / "a.h5") == get(folder / "b.h5"));
}

TEST_CASE("a store of the other width is refused with both widths") {
  const Folder folder;
  write_store(folder / "a.h5", small_visibility());
  const std::string message = refusal(folder / "a.h5", [&] { read_store<std::uint16_t>(folder / "a.h5"); });
  CHECK(contains(message, "8 bits"));
  CHECK(contains(message, "16"));
}
