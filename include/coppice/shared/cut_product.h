// What the kernels of products of cuts read and write: cut_ranks, cut_product_masks and cut_product_values.
#ifndef COPPICE_SHARED_CUT_PRODUCT_H
#define COPPICE_SHARED_CUT_PRODUCT_H
#include <coppice/shared/cut_shade.h>

COPPICE_BEGIN

/// A factor of a receiver's product: a weighted mean of cuts.
struct ProductFactor {
  uint cuts[8];      ///< indices into the store of the factors
  float weights[8];  ///< a cut; sum 1
  uint count;        ///< of the cuts, at most 8
};

COPPICE_END

#ifdef COPPICE_GLSL
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ProductFactors {
  ProductFactor at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer SharedWords { uint at[]; };
#endif

COPPICE_BEGIN

/// Counts where the values of every word of every mask begin, so that a cut's value at any granule is found
/// without a walk from its first.
struct CutRanksParameters {
  COPPICE_ADDRESS(Words) masks;
  COPPICE_ADDRESS(Words) first_value;   ///< by cut
  COPPICE_ADDRESS(WrittenWords) ranks;  ///< a word of the masks: index of the first value whose end is in it
  DispatchRange range;                  ///< of cuts
  uint words;                           ///< of a mask
};

/// What is multiplied.
struct ProductTask {
  CutStore base;                           ///< by receiver, 8 bits a value
  CutStore factors;                        ///< all cuts that factors are means of, 8 bits a value
  COPPICE_ADDRESS(Words) factor_ranks;     ///< of the factors' masks (CutRanksParameters::ranks)
  COPPICE_ADDRESS(Words) first_factor;     ///< by receiver, and one more: index of its first ProductFactor
  COPPICE_ADDRESS(ProductFactors) blends;  ///< of all receivers
};

/// The first pass: the ends of the products. One item a receiver.
struct ProductMasksParameters {
  ProductTask product;
  COPPICE_ADDRESS(WrittenWords) masks;   ///< by receiver
  COPPICE_ADDRESS(WrittenWords) counts;  ///< by receiver: of the ends in its mask
  DispatchRange range;                   ///< of receivers
  uint words;                            ///< of a mask
};

/// The second pass: a value for each end. One item a word of the masks.
struct ProductValuesParameters {
  ProductTask product;
  COPPICE_ADDRESS(Words) base_ranks;
  COPPICE_ADDRESS(Words) masks;         ///< of the first pass
  COPPICE_ADDRESS(Words) ranks;         ///< of these masks
  COPPICE_ADDRESS(SharedWords) values;  ///< 8 bits each; all 0 before
  DispatchRange range;                  ///< of words, those of all receivers
  uint words;                           ///< of a mask
};

COPPICE_END

#ifndef COPPICE_GLSL
namespace coppice {
static_assert(sizeof(ProductFactor) == 68 && offsetof(ProductFactor, count) == 64);
static_assert(offsetof(CutRanksParameters, range) == 24 && offsetof(CutRanksParameters, words) == 32);
static_assert(sizeof(ProductTask) == 72 && offsetof(ProductTask, blends) == 64);
static_assert(offsetof(ProductMasksParameters, range) == 88 && offsetof(ProductMasksParameters, words) == 96);
static_assert(offsetof(ProductValuesParameters, range) == 104 &&
              offsetof(ProductValuesParameters, words) == 112);
static_assert(sizeof(ProductValuesParameters) <= 128, "every device takes 128 bytes of push constants");
}  // namespace coppice
#endif
#endif
