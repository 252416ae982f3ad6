// Attacks the reader of stores. The first byte chooses how: bytes as a file; a whole file with bytes changed;
// or contents with items changed, well sealed, so that what is behind the checksum is attacked too.
#include <algorithm>
#include <coppice/core/random.hpp>
#include <cstdlib>

#include "store/encode.hpp"
#include "store/envelope.hpp"
#include "store/refusal.hpp"

namespace coppice::store {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

/// Numbers out of the fuzzer's bytes; 0 behind their end.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : bytes_(data, size) {}

  bool empty() const { return bytes_.empty(); }
  std::span<const std::uint8_t> rest() const { return bytes_; }

  template <class T>
  T take() {
    T value = 0;
    const std::size_t size = std::min(sizeof(T), bytes_.size());
    if (size > 0) std::memcpy(&value, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
    return value;
  }

  /// Below `count`, which is not 0.
  std::size_t below(std::size_t count) { return take<std::uint32_t>() % count; }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// One triangle, split into four.
ReceiverMesh split_triangle() {
  Mesh mesh;
  mesh.positions = {vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)};
  mesh.normals.assign(3, vec3(0, 0, 1));
  mesh.triangles = {uvec3(0, 1, 2)};
  const SidedTriangle side;
  ReceiverMesh receivers(mesh, {&side, 1});
  const ReceiverMesh::Face f = receivers.faces()[0];
  std::array<std::uint32_t, 3> middle{};
  std::array<vec2, 3> uv{};
  for (std::size_t k = 0; k < 3; ++k) {
    middle[k] =
        receivers.add_corner({0.5f * (mesh.positions[k] + mesh.positions[(k + 1) % 3]), vec3(0, 0, 1)});
    uv[k] = 0.5f * (f.uv[k] + f.uv[(k + 1) % 3]);
  }
  std::vector<ReceiverMesh::Face> children{
      {uvec3(middle[0], middle[1], middle[2]), uv, f.normal, f.triangle}};
  for (std::size_t k = 0; k < 3; ++k)
    children.push_back({uvec3(f.corners[int(k)], middle[k], middle[(k + 2) % 3]),
                        {f.uv[k], uv[k], uv[(k + 2) % 3]},
                        f.normal,
                        f.triangle});
  receivers.subdivide(0, children);
  return receivers;
}

template <Quantised Value>
StoredVisibility<Value> example() {
  Random random(1);
  StoredVisibility<Value> v;
  v.settings = {{"sigma", "2"}};
  std::vector<std::uint32_t> leaves(64, no_light);
  for (std::uint32_t light = 0; light < 50; ++light) {
    leaves[light] = light;
    v.lights.push_back(vec4(random.direction(), 0));
  }
  v.tree = tree_over(std::move(leaves));
  v.mesh = split_triangle();
  v.cuts = MaskedCuts<Value>(64, 0);
  for (std::size_t i = 0; i < v.mesh.corners().size(); ++i) {
    v.receivers.push_back({random.direction(), random.direction()});
    v.cuts.append(Cut<Value>{{8, 16, 32, 48, 49, 50, 52, 56, 64}, std::vector<Value>(9, Value(i))},
                  horizon_of(v.receivers[i], v.weight));
  }
  v.scales.assign(v.receivers.size(), 1);
  return v;
}

/// What was accepted can be used and written again.
template <Quantised Value>
void use(const StoredVisibility<Value>& v) {
  for (std::size_t i = 0; i < v.cuts.size(); ++i)
    require(is_cut(v.tree.leaf_count(), v.cuts.unpack(i).ends) &&
            v.cuts.piece_count(i) == v.cuts.unpack(i).size());
  require(ReceiverMesh::are_faces(v.mesh.corners().size(), v.mesh.faces(), v.mesh.sides().size()));
  for (const SidedTriangle& side : v.mesh.sides()) v.mesh.locate(side, vec2(0.3f, 0.3f));
  encode(v);
}

void read(std::span<const std::byte> file) {
  try {
    Hdf5Reader reader(unseal(file));
    if (reader.count("value_bits") == 16)
      use(decode<std::uint16_t>(reader));
    else
      use(decode<std::uint8_t>(reader));
  } catch (const Refusal& refusal) {
    require(*refusal.what() != '\0' && !refusal.remedy.empty());
  }
}

/// A file with bytes changed is refused.
void read_changed_file(Input& input) {
  static const Bytes whole = to_file(encode(example<std::uint8_t>()));
  Bytes file = whole;
  if (input.take<std::uint8_t>() % 2 == 1) file.resize(input.below(2 * file.size()));
  while (!input.empty() && !file.empty()) {
    const std::size_t at = input.below(file.size());
    file[at] = std::byte(input.take<std::uint8_t>());
  }
  try {
    unseal(file);
  } catch (const Refusal&) {
    return;
  }
  if (file != whole) return;  // a collision of CRC-32: HDF5 would see a file that is not its own
  read(file);
}

/// Counts that were the array's number of rows follow, so that what is behind their check is reached.
void resize(Contents& contents, Array& array, std::uint64_t rows) {
  for (Count& count : contents.counts)
    if (count.value == array.extents[0]) count.value = rows;
  array.extents[0] = rows;
}

void change_array(Contents& contents, Array& array, Input& input) {
  switch (input.take<std::uint8_t>() % 8) {
    case 0:
      resize(contents, array, input.take<std::uint8_t>());
      break;
    case 1:
      array.extents[0] = input.take<std::uint16_t>();
      break;
    case 2:
      array.extents.back() = input.take<std::uint8_t>() % 8;
      break;
    case 3:
      array.element = Element(input.take<std::uint8_t>() % 4);
      break;
    case 4:
      array.block_rows = 1 + input.take<std::uint16_t>();
      array.shuffled = input.take<std::uint8_t>() % 2;
      break;
    default:
      if (array.data.empty()) break;
      const std::size_t at = input.below(array.data.size());
      const std::uint32_t value = input.take<std::uint32_t>();
      std::memcpy(&array.data[at], &value, std::min(sizeof value, array.data.size() - at));
  }
  array.data.resize(element_count(array.extents) * size_of(array.element));
}

void change(Contents& contents, Input& input) {
  const std::uint8_t what = input.take<std::uint8_t>();
  if (what < 64 && !contents.counts.empty()) {
    Count& count = contents.counts[input.below(contents.counts.size())];
    count.value = what < 48 ? input.take<std::uint8_t>() : input.take<std::uint64_t>();
  } else if (what < 68 && !contents.arrays.empty()) {
    contents.arrays.erase(contents.arrays.begin() + std::ptrdiff_t(input.below(contents.arrays.size())));
  } else if (what < 72 && !contents.counts.empty()) {
    contents.counts.erase(contents.counts.begin() + std::ptrdiff_t(input.below(contents.counts.size())));
  } else if (!contents.arrays.empty()) {
    change_array(contents, contents.arrays[input.below(contents.arrays.size())], input);
  }
}

void read_changed_contents(Input& input) {
  static const Contents examples[] = {encode(example<std::uint8_t>()), encode(example<std::uint16_t>()),
                                      encode(StoredVisibility<std::uint8_t>())};
  Contents contents = examples[input.take<std::uint8_t>() % std::size(examples)];
  for (int changes = 0; changes < 20 && !input.empty(); ++changes) change(contents, input);
  read(to_file(contents));
}

}  // namespace
}  // namespace coppice::store

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace coppice::store;
  Input input(data, size);
  switch (input.take<std::uint8_t>() % 8) {
    case 0:
      read(std::as_bytes(input.rest()));
      break;
    case 1:
      read_changed_file(input);
      break;
    default:
      read_changed_contents(input);
  }
  return 0;
}
