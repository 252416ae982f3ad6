// Visibility of some receivers, kept to be used again.
#pragma once

#include <coppice/core/parallel.hpp>
#include <coppice/relight/visibility.hpp>
#include <limits>
#include <span>
#include <vector>

namespace coppice {

/// Rows of bits of some receivers, a bit a leaf of the light tree, words_for_bits(leaf count) words a row.
class VisibilityRows {
 public:
  VisibilityRows() = default;

  /// Dark rows for the receivers named, in this order. Precondition: each is named once.
  VisibilityRows(std::uint32_t leaf_count, std::span<const std::uint32_t> receivers)
      : words_(words_for_bits(leaf_count)), bits_(receivers.size() * words_), count_(receivers.size()) {
    for (std::size_t i = 0; i < receivers.size(); ++i) {
      if (receivers[i] >= row_of_.size()) row_of_.resize(receivers[i] + 1, no_row);
      COPPICE_ASSERT(row_of_[receivers[i]] == no_row);
      row_of_[receivers[i]] = std::uint32_t(i);
    }
  }

  std::size_t size() const { return count_; }
  std::span<std::uint64_t> operator[](std::size_t row) {
    return std::span(bits_).subspan(row * words_, words_);
  }
  std::span<const std::uint64_t> operator[](std::size_t row) const {
    return std::span(bits_).subspan(row * words_, words_);
  }

  /// The row of a receiver; empty where it has none.
  std::span<const std::uint64_t> find(std::size_t receiver) const {
    if (receiver >= row_of_.size() || row_of_[receiver] == no_row) return {};
    return (*this)[row_of_[receiver]];
  }

 private:
  static constexpr std::uint32_t no_row = std::numeric_limits<std::uint32_t>::max();

  std::size_t words_ = 0;
  std::vector<std::uint64_t> bits_;
  std::size_t count_ = 0;
  std::vector<std::uint32_t> row_of_;  // by receiver, as far as the last that has one
};

/// Rows in the order of the leaves of one tree become rows in the order of another over the same lights.
template <Executor E>
void reorder(VisibilityRows& rows, const LightTree& from, const LightTree& to, const E& executor) {
  COPPICE_ASSERT(from.leaf_count() == to.leaf_count());
  const std::uint32_t n = to.leaf_count();
  std::vector<std::uint32_t> old_leaf(n);  // by light, then by new leaf
  for (std::uint32_t leaf = 0; leaf < n; ++leaf)
    if (from.light_of_leaf[leaf] != no_light) old_leaf[from.light_of_leaf[leaf]] = leaf;
  std::vector<std::uint32_t> source(n, n);
  for (std::uint32_t leaf = 0; leaf < n; ++leaf)
    if (to.light_of_leaf[leaf] != no_light) source[leaf] = old_leaf[to.light_of_leaf[leaf]];
  executor(rows.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint64_t> row;
    for (std::size_t i = begin; i < end; ++i) {
      row.assign(rows[i].begin(), rows[i].end());
      std::ranges::fill(rows[i], std::uint64_t{0});
      for (std::uint32_t leaf = 0; leaf < n; ++leaf)
        if (source[leaf] < n)
          rows[i][leaf / 64] |= std::uint64_t(bit_at(row.data(), source[leaf])) << (leaf % 64);
    }
  });
}

}  // namespace coppice
