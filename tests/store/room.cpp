// Prepared rooms: what is written comes back, and what cannot be is refused.
#include "store/room.hpp"

#include <algorithm>
#include <coppice/store/store.hpp>
#include <functional>
#include <limits>

#include "files.hpp"
#include "rooms.hpp"
#include "store/envelope.hpp"
#include "store/hdf5_file.hpp"
#include "store/refusal.hpp"

using namespace store_test;
using store::Bytes;
using store::Kind;

namespace {

using Visibility = LatticeVisibility<std::int8_t>;
using Transfer = LightTransfer<std::int8_t>;

void check_round_trip(const StoredRoom& room) {
  const Folder folder;
  write_room(folder / "a.h5", room);
  const StoredRoom back = read_room(folder / "a.h5");
  check_same(back, room);
  CHECK(back.settings == room.settings);
  CHECK(read_room_settings(folder / "a.h5") == room.settings);
  CHECK(folder.count() == 1);
}

Bytes small_file() { return store::to_file(store::encode(small_room()), Kind::room); }

std::string message_of(std::span<const std::byte> bytes) {
  const Folder folder;
  const fs::path path = put(folder / "a.h5", bytes);
  return refusal(path, [&] { read_room(path); });
}

/// What a reader says of a file with these contents, well sealed.
std::string message_of_contents(const std::function<void(store::Contents&)>& spoil) {
  store::Contents contents = store::encode(small_room());
  spoil(contents);
  return message_of(store::to_file(contents, Kind::room));
}

template <class T>
void set(store::Contents& contents, const std::string& name, std::size_t i, T value) {
  store::Array& array = *std::ranges::find(contents.arrays, name, &store::Array::name);
  REQUIRE(array.element == store::element_of<T>);
  std::memcpy(array.data.data() + i * sizeof(T), &value, sizeof(T));
}

std::string message_of_count(const std::string& name, std::uint64_t value) {
  return message_of_contents(
      [&](store::Contents& c) { std::ranges::find(c.counts, name, &store::Count::name)->value = value; });
}

bool is_refused_at_once(std::span<const std::byte> bytes) {
  try {
    store::unseal(bytes, Kind::room);
  } catch (const store::Refusal&) {
    return true;
  }
  return false;
}

}  // namespace

TEST_CASE("rooms come back bit for bit, in 8 and in 16 bits, centred or not") {
  for (const bool centred : {true, false}) {
    RoomSizes sizes{{100, 1, 700}, {7, 8, 9}, 12, 10, 6, centred};
    check_round_trip(random_room<std::int8_t>(1, sizes));
    check_round_trip(random_room<std::int16_t>(2, sizes));
  }
  StoredRoom mixed = random_room<std::int8_t>(3, {});
  mixed.transfer = random_room<std::int16_t>(3, {}).transfer;
  check_round_trip(mixed);
}

TEST_CASE("a room larger than one block comes back") {
  check_round_trip(random_room<std::int16_t>(4, {{20000, 21000}, {20, 20, 20}, 3, 2, 2, false}));
}

TEST_CASE("rooms of next to nothing come back") {
  check_round_trip(StoredRoom());
  check_round_trip(random_room<std::int8_t>(5, {{}, {0, 0, 0}, 0, 0, 0, false}));
  check_round_trip(random_room<std::int16_t>(6, {{}, {2, 2, 2}, 40, 0, 0, true}));    // no cluster
  check_round_trip(random_room<std::int8_t>(7, {{9}, {3, 3, 3}, 4, 2, 2, true}));     // one
  check_round_trip(random_room<std::int8_t>(8, {{9, 3}, {0, 0, 0}, 4, 2, 2, true}));  // no lattice point
  check_round_trip(random_room<std::int8_t>(9, {{9, 3}, {4, 4, 4}, 0, 0, 0, true}));  // no rank
  StoredRoom rays = small_room();
  rays.visibility = std::monostate();
  check_round_trip(rays);
}

TEST_CASE("equal rooms give equal files") { CHECK(small_file() == small_file()); }

TEST_CASE("a room read as visibility is refused with both kinds, and the reverse") {
  const Folder folder;
  write_room(folder / "room.h5", small_room());
  const auto as_visibility = [&] { read_store<std::uint8_t>(folder / "room.h5"); };
  CHECK(contains(refusal(folder / "room.h5", as_visibility), "is a store of a room, and not of visibility"));
  CHECK(contains(refusal(folder / "room.h5", [&] { read_settings(folder / "room.h5"); }), "not of visibil"));
  write_store(folder / "v.h5", StoredVisibility<std::uint8_t>());
  CHECK(contains(refusal(folder / "v.h5", [&] { read_room(folder / "v.h5"); }),
                 "is a store of visibility, and not of a room"));
  CHECK(contains(refusal(folder / "v.h5", [&] { read_room_settings(folder / "v.h5"); }), "not of a room"));
  Bytes file = small_file();
  store::seal(file, Kind(7));
  CHECK(contains(message_of(file), "unknown kind"));
  CHECK(contains(message_of(Bytes(600, std::byte(1))), "is no store of a room"));
}

TEST_CASE("a room cut short anywhere, or with one bit flipped, is refused before HDF5 sees it") {
  Bytes file = small_file();
  CHECK(message_of(file) == "");
  std::size_t accepted = 0;
  for (std::size_t length = 0; length < file.size(); ++length) {
    const Bytes part(file.begin(), file.begin() + std::ptrdiff_t(length));
    accepted += !is_refused_at_once(part);
  }
  Random random(1);
  for (int trial = 0; trial < 5000; ++trial) {
    const std::size_t at = trial < 512 ? std::size_t(trial) : random.below(std::uint32_t(file.size()));
    const std::byte bit = std::byte(1 << random.below(8));
    file[at] ^= bit;
    accepted += !is_refused_at_once(file);
    file[at] ^= bit;
  }
  CHECK(accepted == 0);
  CHECK_FALSE(is_refused_at_once(file));
  CHECK(contains(message_of(std::span(file).first(file.size() / 2)), "truncated"));
}

TEST_CASE("absurd counts of a room are refused, without the memory that they ask for") {
  for (const store::Count& count : store::encode(small_room()).counts)
    for (const std::uint64_t value : {std::uint64_t(0), count.value + 1, std::uint64_t(0xfffffffeu),
                                      std::uint64_t(1) << 40, ~std::uint64_t(0)}) {
      if (count.name == "visibility_bits" && value == 0) continue;  // a room with shadow rays
      CAPTURE(count.name);
      CAPTURE(value);
      CHECK_FALSE(message_of_count(count.name, value).empty());
    }
  CHECK(contains(message_of_count("visibility_bits", 12), "visibility_bits is 12"));
  CHECK(contains(message_of_count("transfer_bits", 32), "transfer_bits is 32"));
  CHECK(contains(message_of_count("lattice_y", 1u << 30), "lattice_y"));
}

TEST_CASE("missing items of a room, and those of another type or shape, are refused by name") {
  const store::Contents whole = store::encode(small_room());
  for (std::size_t i = 0; i < whole.counts.size(); ++i)
    CHECK(
        contains(message_of_contents([&](auto& c) { c.counts.erase(c.counts.begin() + std::ptrdiff_t(i)); }),
                 "attribute " + whole.counts[i].name + " is missing"));
  for (std::size_t i = 0; i < whole.arrays.size(); ++i) {
    const std::string name = "dataset " + whole.arrays[i].name;
    CHECK(
        contains(message_of_contents([&](auto& c) { c.arrays.erase(c.arrays.begin() + std::ptrdiff_t(i)); }),
                 name + " is missing"));
    CHECK(contains(message_of_contents([&](auto& c) {
                     store::Array& array = c.arrays[i];
                     array.element =
                         array.element == store::Element::i16 ? store::Element::u16 : store::Element::i16;
                     array.data.resize(2 * store::element_count(array.extents));
                   }),
                   name + " has elements of another type"));
    CHECK(contains(message_of_contents([&](auto& c) {
                     store::Array& array = c.arrays[i];
                     array.extents[0] += 1;
                     array.data.resize(store::element_count(array.extents) * size_of(array.element));
                   }),
                   name + " has "));
  }
}

TEST_CASE("a room's content that cannot be is refused by name, though it is well sealed") {
  const auto says = [](const char* text, const std::function<void(store::Contents&)>& spoil) {
    CAPTURE(text);
    const std::string message = message_of_contents(spoil);
    CAPTURE(message);
    CHECK(contains(message, text));
  };
  for (const char* name : {"samples/position", "samples/normal", "samples/colour", "samples/area",
                           "samples/barycentric", "lattice/place", "lattice/position", "visibility/scale",
                           "projection/scale", "pattern/scale", "mix/scale", "mix/offset"})
    says(name, [&](auto& c) { set<float>(c, name, 1, std::numeric_limits<float>::quiet_NaN()); });
  for (const char* name : {"samples/cluster_end", "projection/cluster_end", "pattern/cluster_end"}) {
    says("does not ascend", [&](auto& c) { set<std::uint32_t>(c, name, 0, 1000); });
    says("does not ascend", [&](auto& c) { set<std::uint32_t>(c, name, 2, 1000); });
    says("does not ascend", [&](auto& c) { set<std::uint32_t>(c, name, 2, 0); });
  }
  // Ends that ascend, but give clusters other lengths than their fields have.
  says("projection/value has", [](auto& c) { set<std::uint32_t>(c, "samples/cluster_end", 0, 4); });
  says("neither front nor back", [](auto& c) { set<std::uint8_t>(c, "samples/front", 0, 2); });
  says("area below 0", [](auto& c) { set<float>(c, "samples/area", 0, -1); });
  says("points that are not there", [](auto& c) { set<std::uint32_t>(c, "lattice/number", 0, 60); });
  says("no spacing", [](auto& c) { set<float>(c, "lattice/place", 3, 0); });
  says("visibility/row has", [](auto& c) { set<std::uint32_t>(c, "visibility/index", 0, 0); });
}

TEST_CASE("feature bits behind the lattice points are refused") {
  const StoredRoom room = small_room();
  const auto& v = std::get<Visibility>(room.visibility);
  const std::size_t points = v.lattice.count();
  REQUIRE(points % 32 != 0);
  REQUIRE(points < 32);
  // One bit moves from a point to behind them all, so that the number of rows stays.
  const std::uint32_t bits = v.clusters[0].index.bits[0];
  REQUIRE(bits != 0);
  const std::uint32_t moved = (bits & (bits - 1)) | (1u << 31);
  const std::string message =
      message_of_contents([&](auto& c) { set<std::uint32_t>(c, "visibility/index", 0, moved); });
  CHECK(contains(message, "bits behind the lattice points"));
}

TEST_CASE("a room that does not belong together is refused before it is written") {
  const Folder folder;
  const auto refused = [&](auto&& spoil) {
    StoredRoom room = small_room();
    spoil(room, std::get<Visibility>(room.visibility), std::get<Transfer>(room.transfer));
    const std::string message = refusal(folder / "a.h5", [&] { write_room(folder / "a.h5", room); });
    CHECK(folder.count() == 0);
    return message;
  };
  using Room = StoredRoom;
  const auto says = [&](const char* text, const std::function<void(Room&, Visibility&, Transfer&)>& spoil) {
    CAPTURE(text);
    const std::string message = refused(spoil);
    CAPTURE(message);
    CHECK(contains(message, text));
    CHECK(contains(message, "cannot be written"));
  };
  says("clusters' ends", [](Room& r, auto&, auto&) { r.samples.samples.pop_back(); });
  says("clusters' ends", [](Room& r, auto&, auto&) { std::swap(r.samples.ends[0], r.samples.ends[2]); });
  says("visibility and samples", [](Room&, auto& v, auto&) { v.ends[0] = 4; });
  says("visibility and samples", [](Room&, auto& v, auto&) { v.clusters.pop_back(); });
  says("transfer and samples", [](Room&, auto&, auto& t) { t.sample_ends.pop_back(); });
  says("impossible size", [](Room&, auto& v, auto&) { v.lattice.size.x = -1; });
  says("impossible size", [](Room&, auto& v, auto&) { v.lattice.size.y = 1 << 30; });
  says("impossible size", [](Room&, auto& v, auto&) { v.lattice.size = glm::ivec3((1 << 30) - 1); });
  says("number for each", [](Room&, auto& v, auto&) { v.lattice.numbers.pop_back(); });
  says("not a bit for each", [](Room&, auto& v, auto&) { v.clusters[0].index.bits.push_back(0); });
  says("count its own bits", [](Room&, auto& v, auto&) { v.clusters[0].index.before[0] = 1; });
  says("a scale for each", [](Room&, auto& v, auto&) { v.rank = 4; });
  says("coefficients as samples", [](Room&, auto& v, auto&) { v.clusters[2].coefficients.pop_back(); });
  says("rows that its index", [](Room&, auto& v, auto&) { v.clusters[2].rows.pop_back(); });
  says("the projection: their ends", [](Room&, auto&, auto& t) { t.projection.ends.back() = 1; });
  says("the patterns: not every", [](Room&, auto&, auto& t) { t.patterns.first.pop_back(); });
  says("the patterns: one is not", [](Room&, auto&, auto& t) { t.patterns.first[1] = 4; });
  says("the projection: their values", [](Room&, auto&, auto& t) { t.projection.values.pop_back(); });
  says("columns", [](Room&, auto&, auto& t) { t.mix[0].width += 1; });
  says("a mix has not", [](Room&, auto&, auto& t) { t.mix[1].width -= 1; });
  says("a mix has not", [](Room&, auto&, auto& t) { t.mix[2].values.pop_back(); });
  says("one offset", [](Room&, auto&, auto& t) { t.offsets.pop_back(); });
  says("mix/scale", [](Room&, auto&, auto& t) { t.mix[2].scales[0] = std::nanf(""); });
  CHECK(contains(refused([](Room& r, auto&, auto&) { r.settings[0].value += '\0'; }), "NUL"));
}
