#include "blocks.hpp"

#include <libdeflate.h>

#include <new>

namespace coppice::store {
namespace {

constexpr int compression_level = 9;  // measured: docs/store.md

void shuffle(std::span<const std::byte> from, std::span<std::byte> to, std::size_t element_size) {
  const std::size_t count = from.size() / element_size;
  for (std::size_t b = 0; b < element_size; ++b)
    for (std::size_t i = 0; i < count; ++i) to[b * count + i] = from[i * element_size + b];
}

void unshuffle(std::span<const std::byte> from, std::span<std::byte> to, std::size_t element_size) {
  const std::size_t count = from.size() / element_size;
  for (std::size_t b = 0; b < element_size; ++b)
    for (std::size_t i = 0; i < count; ++i) to[i * element_size + b] = from[b * count + i];
}

}  // namespace

BlockWriter::BlockWriter() : compressor_(libdeflate_alloc_compressor(compression_level)) {
  if (!compressor_) throw std::bad_alloc();
}

void BlockWriter::Free::operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }

std::span<const std::byte> BlockWriter::compress(std::span<const std::byte> block, std::size_t element_size,
                                                 bool shuffled) {
  if (shuffled) {
    shuffled_.resize(block.size());
    shuffle(block, shuffled_, element_size);
    block = shuffled_;
  }
  compressed_.resize(libdeflate_zlib_compress_bound(compressor_.get(), block.size()));
  const std::size_t size = libdeflate_zlib_compress(compressor_.get(), block.data(), block.size(),
                                                    compressed_.data(), compressed_.size());
  return std::span(compressed_).first(size);
}

BlockReader::BlockReader() : decompressor_(libdeflate_alloc_decompressor()) {
  if (!decompressor_) throw std::bad_alloc();
}

void BlockReader::Free::operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }

bool BlockReader::decompress(std::span<const std::byte> compressed, std::span<std::byte> block,
                             std::size_t element_size, bool shuffled) {
  std::span<std::byte> target = block;
  if (shuffled) {
    shuffled_.resize(block.size());
    target = shuffled_;
  }
  const auto result = libdeflate_zlib_decompress(decompressor_.get(), compressed.data(), compressed.size(),
                                                 target.data(), target.size(), nullptr);
  if (result != LIBDEFLATE_SUCCESS) return false;
  if (shuffled) unshuffle(shuffled_, block, element_size);
  return true;
}

}  // namespace coppice::store
