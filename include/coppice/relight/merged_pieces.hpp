// The union of the ends of a face's cuts, with every cut's value on each piece.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <array>
#include <bit>
#include <coppice/cut/masked_cuts.hpp>
#include <coppice/relight/frame_lighting.hpp>
#include <cstdint>
#include <vector>

namespace coppice::inline HWY_NAMESPACE {

namespace merging {

/// Ends of three visibility cuts and of the illumination cut in a word of granules.
template <class Bits>
struct Word {
  Bits a, b, c, illumination;
  Bits all() const { return a | b | c | illumination; }
};

/// ranks[bits][i]: how many of the bits below bit i are set. The rank of a merged piece in a cut, where bit i
/// says that the cut's own piece ends with merged piece i.
inline constexpr auto ranks = [] {
  std::array<std::array<std::uint8_t, 8>, 256> table{};
  for (std::uint32_t bits = 0; bits < 256; ++bits)
    for (std::uint32_t i = 0; i < 8; ++i)
      table[bits][i] = std::uint8_t(std::popcount(bits & ((1u << i) - 1)));
  return table;
}();

/// Eight values, those at the ranks that eight bits tell.
template <class Value>
inline void store_ranked(const Value* values, std::uint64_t bits, Value* to) {
  for (std::size_t i = 0; i < 8; ++i) to[i] = values[ranks[bits][i]];
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
inline constexpr bool has_extract = true;
/// The bits of `bits` at the places that are set in `places`, side by side.
HWY_INLINE std::uint64_t extract(std::uint64_t bits, std::uint64_t places) { return _pext_u64(bits, places); }
HWY_INLINE void store_ranked(const std::uint8_t* values, std::uint64_t bits, std::uint8_t* to) {
  const hn::FixedTag<std::uint8_t, 8> tag;
  hn::StoreU(hn::TableLookupBytes(hn::LoadU(tag, values), hn::LoadU(tag, ranks[bits].data())), tag, to);
}
#else
inline constexpr bool has_extract = false;
inline std::uint64_t extract(std::uint64_t, std::uint64_t) { return 0; }
#endif

}  // namespace merging

/// The pieces of a merged cut: each piece's last leaf plus one, and every cut's value on it.
template <Quantised Value>
class MergedPieces {
 public:
  /// The union of the ends of three visibility cuts and of the illumination cut (Cuts section 3.2, on ends).
  /// A piece's value in a cut is that of rank: the number of the cut's ends before it.
  void merge(const MaskedCuts<Value>& cuts, const uvec3& receivers, const IlluminationCut& frame) {
    reserve(cuts.piece_count(receivers.x) + cuts.piece_count(receivers.y) + cuts.piece_count(receivers.z) +
            frame.ends.size());
    const MaskedCutView<Value> a = cuts[receivers.x], b = cuts[receivers.y], c = cuts[receivers.z];
    at_[0] = a.values, at_[1] = b.values, at_[2] = c.values;
    granule_log2_ = cuts.granule_log2();
    words_.resize(cuts.words_per_cut());
    std::uint32_t w = 0;
    for (; merging::has_extract && w + 2 <= cuts.words_per_cut(); w += 2) {
      const merging::Word<std::uint64_t> word{two_words(a.mask + w), two_words(b.mask + w),
                                              two_words(c.mask + w), two_words(&frame.granule_mask[w])};
      words_[w] = {std::uint32_t(word.all()), std::uint32_t(size_)};
      words_[w + 1] = {std::uint32_t(word.all() >> 32),
                       std::uint32_t(size_) + std::uint32_t(std::popcount(std::uint32_t(word.all())))};
      add_word(word, 32 * w);
    }
    for (; w < cuts.words_per_cut(); ++w) {
      const merging::Word<std::uint32_t> word{a.mask[w], b.mask[w], c.mask[w], frame.granule_mask[w]};
      words_[w] = {word.all(), std::uint32_t(size_)};
      add_bits(word, 32 * w);
    }
  }

  /// Index of the piece that ends with a granule. Precondition: one does.
  std::size_t piece_of(std::uint32_t granule) const {
    const auto& word = words_[granule / 32];
    return word.pieces_before + std::uint32_t(std::popcount(word.ends & ((1u << (granule % 32)) - 1)));
  }
  void hide(std::size_t piece) {
    for (auto& values : values_) values[piece] = 0;
  }

  std::size_t size() const { return size_; }
  /// Element i - 1 is where piece i begins: element -1 is there, and is 0.
  const std::uint32_t* ends() const { return ends_.data() + 1; }
  const Value* values(int cut) const { return values_[std::size_t(cut)].data(); }

 private:
  static std::uint64_t two_words(const std::uint32_t* words) {
    return words[0] | std::uint64_t{words[1]} << 32;
  }
  void reserve(std::size_t capacity) {
    const std::size_t room = capacity + 4 * Lanes::width + 16;  // registers beyond the last piece are read
    if (ends_.size() < room) ends_.assign(room, 0);
    for (auto& values : values_)
      if (values.size() < room) values.assign(room, Value(0));
    size_ = 0;
  }

  /// 64 granules, eight pieces at a time and without a branch on any of them: what is written beyond the last
  /// piece is overwritten by the next word.
  HWY_INLINE void add_word(const merging::Word<std::uint64_t>& word, std::uint32_t first) {
    std::uint64_t ends = word.all();
    const auto count = std::size_t(std::popcount(ends));
    std::uint64_t last[3] = {merging::extract(word.a, ends), merging::extract(word.b, ends),
                             merging::extract(word.c, ends)};
    for (std::size_t k = 0; k < count; k += 8) {
      for (std::size_t i = 1; i <= 8; ++i, ends &= ends - 1)
        ends_[size_ + k + i] = (first + std::uint32_t(std::countr_zero(ends)) + 1) << granule_log2_;
      for (std::size_t j = 0; j < 3; ++j, last[j - 1] >>= 8) {
        merging::store_ranked(at_[j], last[j] & 255, values_[j].data() + size_ + k);
        at_[j] += std::popcount(last[j] & 255);
      }
    }
    size_ += count;
  }

  /// 32 granules one end at a time.
  void add_bits(const merging::Word<std::uint32_t>& word, std::uint32_t first) {
    for (std::uint32_t ends = word.all(); ends != 0; ends &= ends - 1) {
      const auto bit = std::uint32_t(std::countr_zero(ends));
      for (std::size_t j = 0; j < 3; ++j) values_[j][size_] = *at_[j];
      ends_[++size_] = (first + bit + 1) << granule_log2_;
      at_[0] += (word.a >> bit) & 1, at_[1] += (word.b >> bit) & 1, at_[2] += (word.c >> bit) & 1;
    }
  }

  struct WordOfEnds {
    std::uint32_t ends, pieces_before;
  };

  std::vector<std::uint32_t> ends_;
  std::array<std::vector<Value>, 3> values_;
  std::size_t size_ = 0;
  std::array<const Value*, 3> at_{};  ///< by cut: the value of the piece that holds the next leaf
  std::uint32_t granule_log2_ = 0;
  std::vector<WordOfEnds> words_;  ///< of 32 granules
};

}  // namespace coppice::inline HWY_NAMESPACE
