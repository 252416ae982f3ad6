// Files that are cut short, flipped, of another version, or well sealed and yet wrong.
#include <hdf5.h>

#include <algorithm>
#include <functional>

#include "files.hpp"
#include "store/encode.hpp"
#include "store/envelope.hpp"
#include "store/refusal.hpp"
#include "visibilities.hpp"

using namespace store_test;
using store::Bytes;

namespace {

Bytes small_file() { return store::to_file(store::encode(small_visibility())); }

std::string message_of(const Folder& folder, std::span<const std::byte> bytes) {
  const fs::path path = put(folder / "a.h5", bytes);
  return refusal(path, [&] { read_store<std::uint8_t>(path); });
}

bool is_refused_at_once(std::span<const std::byte> bytes) {
  try {
    store::unseal(bytes);
  } catch (const store::Refusal&) {
    return true;
  }
  return false;
}

/// What a reader says of a file with these contents, well sealed.
std::string message_of_contents(const std::function<void(store::Contents&)>& spoil) {
  store::Contents contents = store::encode(small_visibility());
  spoil(contents);
  return message_of(Folder(), store::to_file(contents));
}

store::Array& array_of(store::Contents& contents, const std::string& name) {
  return *std::ranges::find(contents.arrays, name, &store::Array::name);
}

template <class T>
void set(store::Contents& contents, const std::string& name, std::size_t i, T value) {
  store::Array& array = array_of(contents, name);
  REQUIRE(array.element == store::element_of<T>);
  std::memcpy(array.data.data() + i * sizeof(T), &value, sizeof(T));
}

std::string message_of_count(const std::string& name, std::uint64_t value) {
  return message_of_contents(
      [&](store::Contents& c) { std::ranges::find(c.counts, name, &store::Count::name)->value = value; });
}

/// The file with body(file) done to it by the HDF5 library, sealed again.
Bytes with_hdf5(const std::function<void(hid_t)>& body) {
  const Folder folder;
  const fs::path path = put(folder / "patched.h5", small_file());
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  REQUIRE(file >= 0);
  body(file);
  REQUIRE(H5Fclose(file) >= 0);
  Bytes bytes = get(path);
  store::seal(bytes);
  return bytes;
}

/// Replaces a dataset by one of these extents whose blocks were never written.
Bytes with_empty_dataset(const char* name, std::vector<hsize_t> extents, std::vector<hsize_t> block) {
  return with_hdf5([&](hid_t file) {
    REQUIRE(H5Ldelete(file, name, H5P_DEFAULT) >= 0);
    const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(properties, int(block.size()), block.data());
    H5Pset_deflate(properties, 9);
    const hid_t space = H5Screate_simple(int(extents.size()), extents.data(), nullptr);
    const hid_t dataset = H5Dcreate2(file, name, H5T_STD_U32LE, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    REQUIRE(dataset >= 0);
    H5Dclose(dataset), H5Sclose(space), H5Pclose(properties);
  });
}

Bytes with_count(const char* name, std::uint64_t value, Bytes bytes) {
  const Folder folder;
  const fs::path path = put(folder / "patched.h5", bytes);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t attribute = H5Aopen(file, name, H5P_DEFAULT);
  REQUIRE(H5Awrite(attribute, H5T_NATIVE_UINT64, &value) >= 0);
  H5Aclose(attribute), H5Fclose(file);
  bytes = get(path);
  store::seal(bytes);
  return bytes;
}

}  // namespace

TEST_CASE("the small file is whole") {
  const Folder folder;
  CHECK(message_of(folder, small_file()) == "");
  check_same(read_store<std::uint8_t>(folder / "a.h5"), small_visibility());
}

TEST_CASE("a store cut short anywhere is refused before HDF5 sees it") {
  const Bytes file = small_file();
  std::size_t accepted = 0;
  for (std::size_t length = 0; length < file.size(); ++length) {
    const Bytes part(file.begin(),
                     file.begin() + std::ptrdiff_t(length));  // of its own: a sanitizer sees its end
    accepted += !is_refused_at_once(part);
  }
  CHECK(accepted == 0);
  const Folder folder;
  for (const std::size_t length : {std::size_t(0), std::size_t(1), std::size_t(16), std::size_t(511),
                                   std::size_t(512), std::size_t(513), file.size() / 2, file.size() - 1}) {
    CAPTURE(length);
    CHECK_FALSE(message_of(folder, std::span(file).first(length)).empty());
  }
  Bytes longer = file;
  longer.push_back(std::byte(0));
  CHECK(contains(message_of(folder, longer), "truncated or damaged"));
}

TEST_CASE("a store with one bit flipped is refused before HDF5 sees it") {
  Bytes file = small_file();
  std::size_t accepted = 0;
  const auto flip = [&](std::size_t byte, int bit) { file[byte] ^= std::byte(1 << bit); };
  const auto try_flip = [&](std::size_t byte, int bit) {
    flip(byte, bit);
    accepted += !is_refused_at_once(file);
    flip(byte, bit);
  };
  for (std::size_t byte = 0; byte < store::envelope_size; ++byte)
    for (int bit = 0; bit < 8; ++bit) try_flip(byte, bit);
  Random random(1);
  for (int trial = 0; trial < 5000; ++trial)
    try_flip(random.below(std::uint32_t(file.size())), int(random.below(8)));
  CHECK(accepted == 0);
  CHECK_FALSE(is_refused_at_once(file));
}

TEST_CASE("a file of bytes from nowhere is refused") {
  Random random(2);
  const Folder folder;
  for (const std::size_t size : {std::size_t(0), std::size_t(7), std::size_t(600), std::size_t(100000)}) {
    Bytes bytes(size);
    for (std::byte& byte : bytes) byte = std::byte(random.bits());
    CHECK(contains(message_of(folder, bytes), "is no store of visibility"));
  }
}

TEST_CASE("a store of another version is refused with both versions, sealed or not") {
  Bytes file = small_file();
  const std::uint32_t version = store::format_version + 1;
  std::memcpy(file.data() + 16, &version, 4);
  const std::string message = message_of(Folder(), file);
  CHECK(contains(message, "version " + std::to_string(version)));
  CHECK(contains(message, "version " + std::to_string(store::format_version)));
  CHECK(contains(message, "compute it again"));
}

TEST_CASE("what HDF5 cannot open is refused, though it is well sealed") {
  for (const std::size_t size : {std::size_t(0), std::size_t(1), std::size_t(5000)}) {
    Bytes file(store::envelope_size + size, std::byte(7));
    store::seal(file);
    CHECK(contains(message_of(Folder(), file), "HDF5 cannot open it"));
  }
}

TEST_CASE("absurd counts are refused by name, without the memory that they ask for") {
  const store::Contents contents = store::encode(small_visibility());
  for (const store::Count& count : contents.counts)
    for (const std::uint64_t value : {std::uint64_t(0), count.value + 1, std::uint64_t(0xffffffffu),
                                      std::uint64_t(1) << 40, ~std::uint64_t(0)}) {
      if (value == count.value || (count.name == "cosine_weight" && value <= 1)) continue;
      if (count.name == "scale_count" && value == 0) continue;  // the dataset is then found to be too long
      CAPTURE(count.name);
      CAPTURE(value);
      CHECK_FALSE(message_of_count(count.name, value).empty());
    }
  CHECK(contains(message_of_count("receiver_count", ~std::uint64_t(0)), "receiver_count"));
  CHECK(contains(message_of_count("scale_count", 0), "receivers/scale"));
  CHECK(contains(message_of_count("value_bits", 12), "12 bits"));
  CHECK(contains(message_of_count("granule_log2", 40), "granule_log2"));
  CHECK(contains(message_of_count("cosine_weight", 2), "cosine_weight"));
}

TEST_CASE("missing items are refused by name") {
  const store::Contents whole = store::encode(small_visibility());
  for (std::size_t i = 0; i < whole.counts.size(); ++i) {
    const std::string message = message_of_contents(
        [&](store::Contents& c) { c.counts.erase(c.counts.begin() + std::ptrdiff_t(i)); });
    CHECK(contains(message, "attribute " + whole.counts[i].name + " is missing"));
  }
  for (std::size_t i = 0; i < whole.arrays.size(); ++i) {
    const std::string message = message_of_contents(
        [&](store::Contents& c) { c.arrays.erase(c.arrays.begin() + std::ptrdiff_t(i)); });
    CHECK(contains(message, "dataset " + whole.arrays[i].name + " is missing"));
  }
}

TEST_CASE("datasets of another type or shape are refused by name") {
  const store::Contents whole = store::encode(small_visibility());
  for (std::size_t i = 0; i < whole.arrays.size(); ++i) {
    const std::string name = whole.arrays[i].name;
    CHECK(contains(message_of_contents([&](store::Contents& c) {
                     c.arrays[i].element = c.arrays[i].element == store::Element::f32 ? store::Element::u32
                                                                                      : store::Element::f32;
                     c.arrays[i].data.resize(4 * store::element_count(c.arrays[i].extents));
                   }),
                   "dataset " + name + " has elements of another type"));
    CHECK(contains(message_of_contents([&](store::Contents& c) {
                     auto& extents = c.arrays[i].extents;
                     if (extents.size() == 1)
                       extents.push_back(1);
                     else
                       extents = {store::element_count(extents)};
                   }),
                   "dataset " + name + " has "));
  }
}

TEST_CASE("a dataset without its blocks is refused before memory is taken for it") {
  const hsize_t many = hsize_t(1) << 31;
  const Bytes mask =
      with_count("receiver_count", many, with_empty_dataset("cuts/mask", {many, 2}, {1024, 2}));
  CHECK_FALSE(message_of(Folder(), mask).empty());
  const Bytes leaves =
      with_count("leaf_count", many, with_empty_dataset("light_of_leaf", {many}, {many / 4}));
  CHECK(contains(message_of(Folder(), leaves),
                 "dataset light_of_leaf has too few bytes for 2147483648 elements"));
  const Bytes other = with_empty_dataset("light_of_leaf", {128}, {128});
  CHECK(contains(message_of(Folder(), other), "light_of_leaf has too few bytes"));
}

TEST_CASE("a dataset that is stored otherwise is refused") {
  const Bytes file = with_hdf5([](hid_t id) {
    REQUIRE(H5Ldelete(id, "light_of_leaf", H5P_DEFAULT) >= 0);
    const hsize_t leaves = 128;
    const hid_t space = H5Screate_simple(1, &leaves, nullptr);
    const hid_t dataset =
        H5Dcreate2(id, "light_of_leaf", H5T_STD_U32LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dclose(dataset), H5Sclose(space);
  });
  CHECK(contains(message_of(Folder(), file), "is not compressed as stores are"));
}

TEST_CASE("content that cannot be is refused by name, though it is well sealed") {
  const auto says = [](const char* text, const std::function<void(store::Contents&)>& spoil) {
    CAPTURE(text);
    const std::string message = message_of_contents(spoil);
    CAPTURE(message);
    CHECK(contains(message, text));
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const char* name :
       {"lights", "mesh/corner_position", "mesh/corner_normal", "mesh/root_normal", "receivers/position",
        "receivers/normal", "receivers/horizon", "receivers/bend", "receivers/scale"})
    says(name, [&](auto& c) { set<float>(c, name, 3, nan); });
  says("light_of_leaf", [](auto& c) { set<std::uint32_t>(c, "light_of_leaf", 0, 100); });
  says("light_of_leaf", [](auto& c) {
    for (std::size_t leaf : {0u, 1u, 2u}) set<std::uint32_t>(c, "light_of_leaf", leaf, 5);
  });
  says("without corners", [](auto& c) { set<std::uint32_t>(c, "mesh/root_corners", 0, 1000); });
  says("neither front nor back", [](auto& c) { set<std::uint8_t>(c, "mesh/root_front", 0, 2); });
  says("splits a face twice", [](auto& c) { set<std::uint32_t>(c, "mesh/split_face", 0, 100000); });
  says("more children than its middles", [](auto& c) {
    const std::size_t children = array_of(c, "mesh/child").extents[0];
    for (std::size_t i = 0; i < children; ++i) set<std::uint8_t>(c, "mesh/child", i, 0 + 6 * 1 + 36 * 2);
  });
  says("lacks children", [](auto& c) { set<std::uint8_t>(c, "mesh/split_children", 0, 255); });
  says("lacks children", [](auto& c) { set<std::uint8_t>(c, "mesh/split_children", 0, 0); });
  says("unknown shape", [](auto& c) { set<std::uint8_t>(c, "mesh/child", 0, 216); });
  says("no corner", [](auto& c) { set<std::uint32_t>(c, "mesh/middle", 0, 1u << 30); });
  says("nowhere", [](auto& c) {
    const std::size_t middles = array_of(c, "mesh/middle").extents[0];
    for (std::size_t i = 0; i < middles; ++i) set<std::uint32_t>(c, "mesh/middle", i, 0);
  });
  says("cuts/mask", [](auto& c) { set<std::uint32_t>(c, "cuts/mask", 0, 0x10u); });
  says("cuts/mask", [](auto& c) { set<std::uint32_t>(c, "cuts/mask", 1, 0u); });
  says("settings breaks off", [](auto& c) { array_of(c, "settings").data.back() = std::byte('x'); });
  says("key without a value", [](auto& c) { array_of(c, "settings").data.front() = std::byte(0); });
}
