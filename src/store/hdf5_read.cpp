#include <algorithm>
#include <optional>

#include "blocks.hpp"
#include "hdf5_file.hpp"
#include "hdf5_handle.hpp"
#include "refusal.hpp"

namespace coppice::store {
namespace {

constexpr std::uint64_t most_from_one_byte = 1032;  // deflate, by its format

Handle open_image(std::span<const std::byte> payload) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr std::size_t growth = 1 << 20;
  H5Pset_fapl_core(access, growth, false);
  H5Pset_file_image(access, const_cast<std::byte*>(payload.data()), payload.size());  // copied
  return {H5Fopen("store", H5F_ACC_RDONLY, access), H5Fclose};
}

std::string text_of(std::span<const hsize_t> extents) {
  std::string text;
  for (const hsize_t extent : extents) text += (text.empty() ? "" : " x ") + std::to_string(extent);
  return text.empty() ? "no extent" : text;
}

std::vector<hsize_t> extents_of(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 1 || rank > 2) return {};
  std::vector<hsize_t> extents(std::size_t(rank), 0);
  H5Sget_simple_extent_dims(space, extents.data(), nullptr);
  return extents;
}

/// How a dataset's blocks lie in the file.
struct Blocks {
  std::size_t rows = 0;
  bool shuffled = false;
};

/// Blocks of whole rows, deflated, perhaps shuffled before: all that is written, and all that is read.
std::optional<Blocks> blocks_of(hid_t dataset, std::span<const hsize_t> extents) {
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_layout(properties) != H5D_CHUNKED) return std::nullopt;
  hsize_t block[2] = {0, 0};
  if (H5Pget_chunk(properties, 2, block) != int(extents.size())) return std::nullopt;
  if (block[0] == 0 || block[0] > extents[0] || (extents.size() == 2 && block[1] != extents[1]))
    return std::nullopt;
  std::vector<H5Z_filter_t> filters;
  for (int i = 0; i < H5Pget_nfilters(properties); ++i) {
    unsigned flags = 0, config = 0;
    std::size_t values = 0;
    filters.push_back(H5Pget_filter2(properties, unsigned(i), &flags, &values, nullptr, 0, nullptr, &config));
  }
  const Blocks result{std::size_t(block[0]), filters.size() == 2};
  if (filters.empty() || filters.size() > 2 || filters.back() != H5Z_FILTER_DEFLATE) return std::nullopt;
  if (result.shuffled && filters.front() != H5Z_FILTER_SHUFFLE) return std::nullopt;
  return result;
}

/// Whether `compressed` bytes can hold as many elements in whole blocks.
bool can_fill(std::uint64_t compressed, std::span<const hsize_t> extents, std::size_t block_rows,
              std::size_t element_size) {
  const std::uint64_t columns = extents.size() == 2 ? extents[1] : 1;
  const std::uint64_t most = compressed * most_from_one_byte / element_size / columns;  // rows
  const std::uint64_t blocks = extents[0] / block_rows + (extents[0] % block_rows != 0);
  return most >= extents[0] && blocks <= most / block_rows;
}

}  // namespace

struct Hdf5Reader::State {
  Hdf5Session session;
  std::uint64_t payload_size;
  Handle file;
  BlockReader decompressor{};
  Bytes compressed{}, last{};

  // The array that was last required.
  std::optional<Handle> dataset{};
  Element element = Element::u8;
  std::vector<hsize_t> extents{};
  Blocks blocks{};

  explicit State(std::span<const std::byte> payload)
      : payload_size(payload.size()), file(open_image(payload)) {}

  void fetch_block(const std::string& name, const hsize_t* offset) {
    hsize_t size = 0;
    if (H5Dget_chunk_storage_size(*dataset, offset, &size) < 0 || size == 0 || size > payload_size)
      throw Refusal("dataset " + name + " lacks a block");
    compressed.resize(size);
    std::uint32_t filters_left_out = 0;
    if (H5Dread_chunk(*dataset, H5P_DEFAULT, offset, &filters_left_out, compressed.data()) < 0 ||
        filters_left_out != 0)
      throw Refusal("dataset " + name + " has a block that cannot be read");
  }
};

Hdf5Reader::Hdf5Reader(std::span<const std::byte> payload) : state_(std::make_unique<State>(payload)) {
  if (!state_->file.is_valid()) throw Refusal("is damaged: HDF5 cannot open it");
}

Hdf5Reader::~Hdf5Reader() = default;

std::uint64_t Hdf5Reader::count(const std::string& name) const {
  const Handle attribute(H5Aopen(state_->file, name.c_str(), H5P_DEFAULT), H5Aclose);
  if (!attribute.is_valid()) throw Refusal("attribute " + name + " is missing");
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  std::uint64_t value = 0;
  if (H5Tequal(type, H5T_STD_U64LE) <= 0 || H5Sget_simple_extent_type(space) != H5S_SCALAR ||
      H5Aread(attribute, H5T_NATIVE_UINT64, &value) < 0)
    throw Refusal("attribute " + name + " is not one 64-bit number");
  return value;
}

void Hdf5Reader::require(const std::string& name, Element element, std::span<const std::uint64_t> extents) {
  State& s = *state_;
  s.dataset.reset();
  s.dataset.emplace(H5Dopen2(s.file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!s.dataset->is_valid()) throw Refusal("dataset " + name + " is missing");
  const Handle type(H5Dget_type(*s.dataset), H5Tclose);
  if (H5Tequal(type, file_type(element)) <= 0)
    throw Refusal("dataset " + name + " has elements of another type");
  s.element = element, s.extents = extents_of(*s.dataset);
  if (!std::ranges::equal(s.extents, extents))
    throw Refusal("dataset " + name + " has " + text_of(s.extents) + " elements, and the counts ask for " +
                  text_of(std::vector<hsize_t>(extents.begin(), extents.end())));
  if (std::ranges::find(s.extents, hsize_t{0}) != s.extents.end()) return;
  const auto blocks = blocks_of(*s.dataset, s.extents);
  if (!blocks) throw Refusal("dataset " + name + " is not compressed as stores are");
  s.blocks = *blocks;
  const std::uint64_t compressed = std::min<std::uint64_t>(H5Dget_storage_size(*s.dataset), s.payload_size);
  if (!can_fill(compressed, s.extents, s.blocks.rows, size_of(element)))
    throw Refusal("dataset " + name + " has too few bytes for " + text_of(s.extents) + " elements");
}

void Hdf5Reader::read(const std::string& name, std::span<std::byte> values) {
  if (values.empty()) return;
  State& s = *state_;
  const std::size_t row = values.size() / s.extents[0], rows = s.blocks.rows, element = size_of(s.element);
  for (std::size_t first = 0; first < s.extents[0]; first += rows) {
    const hsize_t offset[2] = {first, 0};
    s.fetch_block(name, offset);
    const std::size_t count = std::min<std::size_t>(rows, s.extents[0] - first);
    const std::span<std::byte> target = values.subspan(first * row, count * row);
    if (count < rows) s.last.resize(rows * row);
    if (!s.decompressor.decompress(s.compressed, count < rows ? std::span<std::byte>(s.last) : target,
                                   element, element > 1 && s.blocks.shuffled))
      throw Refusal("dataset " + name + " has a block that does not decompress to its size");
    if (count < rows) std::ranges::copy(std::span(s.last).first(target.size()), target.begin());
  }
}

}  // namespace coppice::store
