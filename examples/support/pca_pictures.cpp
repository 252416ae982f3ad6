#include <support/pca_pictures.hpp>
//
#include <cmath>
#include <coppice/exr/write.hpp>
#include <coppice/transfer/transfer_matrix.hpp>

namespace coppice::program {
namespace {

constexpr std::size_t most_vectors = 4;
constexpr int gap = 4;  // pixels between pictures

/// Draws fields over samples, without what the surfaces' own colours do to light.
class FieldPainter {
 public:
  explicit FieldPainter(const PcaView& view, std::size_t samples)
      : view_(view), white_(view.indirect(std::vector<vec3>(samples, vec3(1)))) {}

  /// Means of the field over each pixel's splats; black where the surface reflects nothing.
  Image means(std::span<const vec3> field) const {
    Image image = view_.indirect(field);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      for (int c = 0; c < 3; ++c)
        image.pixels[i][c] = white_.pixels[i][c] > 0 ? image.pixels[i][c] / white_.pixels[i][c] : 0;
    return image;
  }

  /// Red above zero, blue below, over a dim grey picture of the room. `scale`: what is full red.
  Image signs(std::span<const float> field, float scale) const {
    std::vector<vec3> colours;
    for (const float x : field) colours.emplace_back(std::max(x, 0.0f), 0, std::max(-x, 0.0f));
    Image image = means(colours);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      vec3& p = image.pixels[i];
      const vec3 share = glm::min(p / std::max(scale, 1e-30f), vec3(1));
      p = shade(i) * std::max(1 - share.x - share.z, 0.0f) + share;
    }
    return image;
  }

  /// A grey that lets the room's shapes be seen.
  vec3 shade(std::size_t pixel) const { return vec3(0.3f * luminance(white_.pixels[pixel])); }

 private:
  const PcaView& view_;
  Image white_;
};

/// The magnitude below which 99% of those above zero lie.
float usual_limit(std::span<const float> field) {
  std::vector<float> sizes;
  for (const float x : field)
    if (x != 0) sizes.push_back(std::abs(x));
  if (sizes.empty()) return 0;
  const auto nth = sizes.begin() + std::ptrdiff_t(0.99 * double(sizes.size() - 1));
  std::ranges::nth_element(sizes, nth);
  return *nth;
}

std::size_t most_seen_cluster(const FieldPainter& painter, const ClusteredSamples& samples,
                              const LightBasis& basis) {
  std::size_t best = 0;
  double most = -1;
  for (std::size_t c = 0; c < samples.cluster_count(); ++c) {
    if (basis.clusters[c].rank() == 0) continue;
    std::vector<vec3> field(samples.size(), vec3(0));
    std::fill(field.begin() + std::ptrdiff_t(samples.begin(c)),
              field.begin() + std::ptrdiff_t(samples.end(c)), vec3(1));
    double sum = 0;
    for (const vec3& p : painter.means(field).pixels) sum += double(luminance(p));
    if (sum > most) most = sum, best = c;
  }
  return best;
}

/// Hues that differ much between neighbours in number.
vec3 colour_of(std::size_t cluster) {
  const float hue = float(cluster) * 0.618034f, size = cluster % 2 == 0 ? 0.5f : 0.2f;
  vec3 colour(0);
  for (int c = 0; c < 3; ++c) colour[c] = 0.5f + 0.5f * std::cos(2 * pi * (hue + float(c) / 3));
  return size * colour * colour;
}

Image cluster_picture(const FieldPainter& painter, const ClusteredSamples& samples) {
  std::vector<vec3> colours;
  for (std::size_t c = 0; c < samples.cluster_count(); ++c)
    colours.insert(colours.end(), samples.size(c), colour_of(c));
  return painter.means(colours);
}

/// Pictures side by side and in rows, all of one size, on white.
class Sheet {
 public:
  Sheet(int columns, int rows, int width, int height)
      : width_(width),
        height_(height),
        image_(columns * (width + gap) - gap, rows * (height + gap) - gap, vec3(4)) {}

  void put(int column, int row, const Image& picture) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x)
        image_.at(column * (width_ + gap) + x, row * (height_ + gap) + y) = picture.at(x, y);
  }
  const Image& image() const { return image_; }

 private:
  int width_, height_;
  Image image_;
};

Sheet basis_sheet(const FieldPainter& painter, const PcaView& view, const ClusteredSamples& samples,
                  const LightBasis& basis, const Rows& matrix) {
  const std::size_t cluster = most_seen_cluster(painter, samples, basis);
  std::size_t first = 0;
  for (std::size_t c = 0; c < cluster; ++c) first += basis.clusters[c].rank();
  const std::size_t vectors = std::min(most_vectors, basis.clusters[cluster].rank());
  const Image& seen = view.seen().emission;
  Sheet sheet(int(std::max<std::size_t>(vectors, 1)), 2, seen.width, seen.height);
  for (std::size_t j = 0; j < vectors; ++j) {
    const std::vector<float> emitted = emission_field(samples, basis, cluster, j);
    std::vector<float> received;
    for (const vec3& e : response_field(matrix, first + j)) received.push_back(luminance(e));
    sheet.put(int(j), 0, painter.signs(emitted, usual_limit(emitted)));
    sheet.put(int(j), 1, painter.signs(received, usual_limit(received)));
  }
  return sheet;
}

}  // namespace

std::vector<std::filesystem::path> pca_picture_paths(const std::filesystem::path& folder) {
  return {folder / "clusters.png", folder / "basis_vectors.png"};
}

void write_pca_pictures(const std::filesystem::path& folder, const PcaView& view,
                        const ClusteredSamples& samples, const LightBasis& basis, const Rows& matrix) {
  const FieldPainter painter(view, samples.size());
  const auto paths = pca_picture_paths(folder);
  write_png(paths[0], cluster_picture(painter, samples));
  write_png(paths[1], basis_sheet(painter, view, samples, basis, matrix).image());
}

}  // namespace coppice::program
