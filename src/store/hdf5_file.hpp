// Counts and arrays as an HDF5 file in memory.
#pragma once

#include <concepts>
#include <memory>
#include <span>
#include <string>

#include "contents.hpp"
#include "envelope.hpp"

namespace coppice::store {

/// A whole store: a sealed envelope, and behind it an HDF5 file with each count as an attribute of the root
/// and each array as a dataset. Throws Refusal where HDF5 fails.
Bytes to_file(const Contents& contents, Kind kind = Kind::visibility);

/// Reads single items of the HDF5 file behind an envelope that was found to be whole. Every item is checked
/// against what is asked for; throws Refusal naming it. An array is allocated only where the compressed bytes
/// that are there can fill it: deflate makes at most 1,032 bytes of one.
class Hdf5Reader {
 public:
  explicit Hdf5Reader(std::span<const std::byte> payload);
  ~Hdf5Reader();

  std::uint64_t count(const std::string& name) const;

  template <class T>
  std::vector<T> array(const std::string& name, std::vector<std::uint64_t> extents) {
    require(name, element_of<T>, extents);
    std::vector<T> values(element_count(extents));
    read(name, std::as_writable_bytes(std::span(values)));
    return values;
  }

 private:
  struct State;

  void require(const std::string& name, Element element, std::span<const std::uint64_t> extents);
  /// Of the array that was last required.
  void read(const std::string& name, std::span<std::byte> values);

  std::unique_ptr<State> state_;
};

}  // namespace coppice::store
