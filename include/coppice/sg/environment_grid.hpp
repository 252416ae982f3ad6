// Gathers an environment map into a HEALPix grid, its energy kept.
#pragma once

#include <coppice/core/config.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/light/environment.hpp>
#include <coppice/sg/healpix.hpp>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace coppice {

/// What lies in one pixel of the grid.
struct EnvironmentCell {
  vec3 energy{0};  ///< Σ radiance · solid angle, linear RGB
  vec3 centre{0};  ///< unit mean direction of its texels by their luminance; of black ones, by area
};

/// Which texels of a map lie in which pixel of a HEALPix grid. It depends on the sizes alone, and is made
/// once; each texel, or each part of one where the map is coarse, goes to one pixel whole.
class EnvironmentGrid {
 public:
  /// For maps of width × height texels; coarse maps are subdivided to at least 16 nside rows and 32 nside
  /// columns. Cost: about 50 ns a texel. Precondition: at least one texel.
  EnvironmentGrid(int nside, int width, int height) : grid_(nside), width_(width), height_(height) {
    COPPICE_ASSERT(width > 0 && height > 0);
    across_ = std::max(1, (32 * nside + width - 1) / width);
    down_ = std::max(1, (16 * nside + height - 1) / height);
    make_directions();
    std::vector<std::pair<std::uint32_t, Run>> found;
    for (int y = 0; y < height_ * down_; ++y) append_row(y, found);
    sort_by_pixel(found);
    for (const EnvironmentCell& cell : gather(Image(width, height, vec3(1)))) {
      areas_.push_back(cell.energy.x);
      centres_.push_back(cell.centre);
    }
  }

  const Healpix& healpix() const { return grid_; }
  int width() const { return width_; }
  int height() const { return height_; }
  /// Steradians of the texels of each pixel: near, but not, those of the pixel. They add up to 4π.
  std::span<const float> areas() const { return areas_; }
  /// Unit mean direction of each pixel's texels by area.
  std::span<const vec3> centres() const { return centres_; }

  /// Energy of each pixel and where it comes from, of the map as it is, not turned. Sums of energy in double:
  /// to 1e-7. Precondition: the map has the constructor's size. Cost: docs/sg.md.
  template <Executor E = Serial>
  std::vector<EnvironmentCell> gather(const Image& map, const E& executor = {}) const {
    COPPICE_ASSERT(map.width == width_ && map.height == height_);
    std::vector<EnvironmentCell> cells(grid_.pixel_count());
    executor(cells.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) cells[i] = cell_of(map, i);
    });
    return cells;
  }

 private:
  /// `count` texels of a row from `first` on, or a part of one texel.
  struct Run {
    std::uint32_t first, count;
    std::uint32_t row;          ///< of the subdivided map
    std::uint32_t half_column;  ///< of the first one's middle; that of the next one is two further
    double solid_angle;         ///< of each
  };
  struct Row {
    double cosine, sine;
  };

  void make_directions() {
    const int rows = height_ * down_, half_columns = 2 * width_ * across_;
    for (int y = 0; y < rows; ++y) {
      const double elevation = std::numbers::pi * (0.5 - (y + 0.5) / rows);
      rows_.push_back({std::cos(elevation), std::sin(elevation)});
    }
    for (int x = 0; x < half_columns; ++x) {
      const double azimuth = 2 * std::numbers::pi * (double(x) / half_columns - 0.5);
      half_columns_.push_back(vec3(glm::dvec3(std::cos(azimuth), 1, std::sin(azimuth))));
    }
  }

  /// Adds the energy of a run, and Σ luminance · solid angle · (direction, 1).
  void add(const Image& map, const Run& run, glm::dvec3& energy, glm::dvec4& place) const {
    const vec3* texel = &map.pixels[run.first];
    const vec3* column = &half_columns_[run.half_column];
    glm::dvec3 radiance(0);
    vec3 weights(0);
    for (std::uint32_t i = 0; i < run.count; ++i) {
      radiance += glm::dvec3(texel[i]);
      weights += luminance(texel[i]) * column[2 * i];
    }
    const Row& row = rows_[run.row];
    const glm::dvec3 w(weights);
    energy += run.solid_angle * radiance;
    place += run.solid_angle * glm::dvec4(row.cosine * w.x, row.sine * w.y, row.cosine * w.z, w.y);
  }

  EnvironmentCell cell_of(const Image& map, std::size_t pixel) const {
    glm::dvec3 energy(0);
    glm::dvec4 place(0);
    for (std::uint32_t r = begins_[pixel]; r < begins_[pixel + 1]; ++r) add(map, runs_[r], energy, place);
    const double size = glm::length(glm::dvec3(place));
    if (size > 1e-6 * place.w) return {vec3(energy), vec3(glm::dvec3(place) / size)};
    return {vec3(energy), centres_.empty() ? grid_.centre(std::uint32_t(pixel)) : centres_[pixel]};
  }

  /// Splits a row of the subdivided map into runs that lie in one pixel.
  void append_row(int y, std::vector<std::pair<std::uint32_t, Run>>& found) const {
    const int columns = width_ * across_;
    const double elevation = std::numbers::pi * (0.5 - (y + 0.5) / (height_ * down_));
    const double s = std::sin(std::numbers::pi / 4 - std::abs(elevation) / 2);
    const double solid_angle = texel_solid_angle(y, columns, height_ * down_);
    const std::uint32_t row = std::uint32_t(y / down_) * std::uint32_t(width_);
    for (int x = 0; x < columns; ++x) {
      const std::uint32_t pixel = grid_.pixel(std::sin(elevation), 2 * s * s, (x + 0.5) / columns - 0.5);
      const Run texel{row + std::uint32_t(x / across_), 1, std::uint32_t(y), std::uint32_t(2 * x + 1),
                      solid_angle};
      if (x == 0 || found.back().first != pixel || !extend(found.back().second, texel))
        found.push_back({pixel, texel});
    }
  }

  /// Adds the next texel, or the next part of the same one, to a run that it may go on with.
  bool extend(Run& run, const Run& texel) const {
    if (across_ == 1) {
      ++run.count;
      return true;
    }
    if (run.first != texel.first) return false;
    run.solid_angle += texel.solid_angle;
    ++run.half_column;
    return true;
  }

  /// Counting sort.
  void sort_by_pixel(const std::vector<std::pair<std::uint32_t, Run>>& found) {
    begins_.assign(grid_.pixel_count() + 1, 0);
    for (const auto& [pixel, run] : found) ++begins_[pixel + 1];
    for (std::size_t i = 0; i + 1 < begins_.size(); ++i) begins_[i + 1] += begins_[i];
    runs_.resize(found.size());
    std::vector<std::uint32_t> next(begins_.begin(), begins_.end() - 1);
    for (const auto& [pixel, run] : found) runs_[next[pixel]++] = run;
  }

  Healpix grid_;
  int width_, height_;
  int across_ = 1, down_ = 1;       ///< parts of a texel
  std::vector<Row> rows_;           ///< of the subdivided map
  std::vector<vec3> half_columns_;  ///< cosine, 1, sine of their azimuths
  std::vector<float> areas_;
  std::vector<vec3> centres_;
  std::vector<std::uint32_t> begins_;  ///< of each pixel's runs, and the end
  std::vector<Run> runs_;
};

}  // namespace coppice
