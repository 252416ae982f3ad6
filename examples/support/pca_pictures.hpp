// Pictures of clusters and of basis vectors, on what the camera sees.
#pragma once

#include <coppice/core/simd.hpp>
//
#include <coppice/transfer/light_basis.hpp>
#include <filesystem>
#include <support/pca_view.hpp>

namespace coppice::program {

/// The files that write_pca_pictures() writes into the folder.
std::vector<std::filesystem::path> pca_picture_paths(const std::filesystem::path& folder);

/// clusters.png: each cluster in a colour of its own (PCA Fig. 1). basis_vectors.png: of the cluster that is
/// seen most, its first vectors from left to right, above what it emits, below what all other samples receive
/// of that; red where positive, blue where negative (PCA Fig. 3). `matrix`: transfer_matrix() of the basis.
/// Throws InputError where they cannot be written.
void write_pca_pictures(const std::filesystem::path& folder, const PcaView& view,
                        const ClusteredSamples& samples, const LightBasis& basis, const Rows& matrix);

}  // namespace coppice::program
