#include <algorithm>
#include <coppice/core/config.hpp>

#include "blocks.hpp"
#include "hdf5_file.hpp"
#include "hdf5_handle.hpp"
#include "refusal.hpp"

namespace coppice::store {
namespace {

template <class Result>
Result require(Result result, const std::string& what) {
  if (result < 0)
    throw Refusal("cannot be made: HDF5 fails at " + what, "report this as a fault of the program");
  return result;
}

Handle new_properties(hid_t kind) { return {require(H5Pcreate(kind), "properties"), H5Pclose}; }

/// A file that lives in memory only, in HDF5's oldest format, which every version reads. (To files of newer
/// ones H5Fget_file_image of HDF5 1.10.8 gives a wrong checksum.)
Handle new_file() {
  const Handle access = new_properties(H5P_FILE_ACCESS);
  constexpr std::size_t growth = 1 << 20;
  require(H5Pset_fapl_core(access, growth, false), "memory");
  return {require(H5Fcreate("store", H5F_ACC_TRUNC, H5P_DEFAULT, access), "the file"), H5Fclose};
}

void write_count(hid_t file, const Count& count) {
  const Handle space(require(H5Screate(H5S_SCALAR), count.name), H5Sclose);
  const Handle attribute(
      require(H5Acreate2(file, count.name.c_str(), H5T_STD_U64LE, space, H5P_DEFAULT, H5P_DEFAULT),
              count.name),
      H5Aclose);
  require(H5Awrite(attribute, H5T_NATIVE_UINT64, &count.value), count.name);
}

bool is_shuffled(const Array& array) { return array.shuffled && size_of(array.element) > 1; }

std::vector<hsize_t> block_extents(const Array& array) {
  std::vector<hsize_t> extents(array.extents.begin(), array.extents.end());
  extents[0] = std::min<hsize_t>(array.block_rows, extents[0]);
  return extents;
}

/// Without elements a dataset has no blocks.
Handle dataset_properties(const Array& array) {
  Handle properties = new_properties(H5P_DATASET_CREATE);
  require(H5Pset_obj_track_times(properties, false), array.name);  // equal content gives equal files
  if (element_count(array.extents) == 0) return properties;
  const auto block = block_extents(array);
  require(H5Pset_chunk(properties, int(block.size()), block.data()), array.name);
  if (is_shuffled(array)) require(H5Pset_shuffle(properties), array.name);
  require(H5Pset_deflate(properties, 9), array.name);
  return properties;
}

/// HDF5 keeps whole blocks: the last one is filled up with zeros.
void write_blocks(hid_t dataset, const Array& array, BlockWriter& writer) {
  const std::size_t element = size_of(array.element);
  const std::size_t row = array.data.size() / array.extents[0], rows = block_extents(array)[0];
  Bytes last(rows * row);
  for (std::size_t first = 0; first < array.extents[0]; first += rows) {
    const std::size_t count = std::min<std::size_t>(rows, array.extents[0] - first);
    std::span<const std::byte> block = std::span(array.data).subspan(first * row, count * row);
    if (count < rows) {
      std::ranges::copy(block, last.begin());
      block = last;
    }
    const auto compressed = writer.compress(block, element, is_shuffled(array));
    const hsize_t offset[2] = {first, 0};
    require(H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, offset, compressed.size(), compressed.data()),
            array.name);
  }
}

void write_array(hid_t file, const Array& array, BlockWriter& writer) {
  COPPICE_ASSERT(array.data.size() == element_count(array.extents) * size_of(array.element));
  const Handle properties = dataset_properties(array);
  const Handle links = new_properties(H5P_LINK_CREATE);
  require(H5Pset_create_intermediate_group(links, 1), array.name);
  const std::vector<hsize_t> extents(array.extents.begin(), array.extents.end());
  const Handle space(require(H5Screate_simple(int(extents.size()), extents.data(), nullptr), array.name),
                     H5Sclose);
  const Handle dataset(require(H5Dcreate2(file, array.name.c_str(), file_type(array.element), space, links,
                                          properties, H5P_DEFAULT),
                               array.name),
                       H5Dclose);
  if (!array.data.empty()) write_blocks(dataset, array, writer);
}

}  // namespace

Bytes to_file(const Contents& contents, Kind kind) {
  const Hdf5Session session;
  const Handle file = new_file();
  for (const Count& count : contents.counts) write_count(file, count);
  BlockWriter writer;
  for (const Array& array : contents.arrays) write_array(file, array, writer);
  require(H5Fflush(file, H5F_SCOPE_GLOBAL), "the end");
  const ssize_t size = require(H5Fget_file_image(file, nullptr, 0), "its size");
  Bytes bytes(envelope_size + std::size_t(size));
  require(H5Fget_file_image(file, bytes.data() + envelope_size, std::size_t(size)), "its bytes");
  seal(bytes, kind);
  return bytes;
}

}  // namespace coppice::store
