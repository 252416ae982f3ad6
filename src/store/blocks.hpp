// Blocks of bytes as HDF5's filters shuffle and deflate leave them, through libdeflate.
#pragma once

#include <memory>
#include <span>

#include "contents.hpp"

struct libdeflate_compressor;
struct libdeflate_decompressor;

namespace coppice::store {

/// Elements of several bytes are shuffled before they are compressed: all first bytes, then all second ones.
/// Floats and ascending numbers get smaller by it; masks do not.
class BlockWriter {
 public:
  BlockWriter();

  /// The compressed block; valid until the next call.
  std::span<const std::byte> compress(std::span<const std::byte> block, std::size_t element_size,
                                      bool shuffled);

 private:
  struct Free {
    void operator()(libdeflate_compressor* c) const;
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
  Bytes shuffled_, compressed_;
};

class BlockReader {
 public:
  BlockReader();

  /// Fills `block`; false where the data do not decompress to exactly its size.
  bool decompress(std::span<const std::byte> compressed, std::span<std::byte> block, std::size_t element_size,
                  bool shuffled);

 private:
  struct Free {
    void operator()(libdeflate_decompressor* d) const;
  };
  std::unique_ptr<libdeflate_decompressor, Free> decompressor_;
  Bytes shuffled_;
};

}  // namespace coppice::store
