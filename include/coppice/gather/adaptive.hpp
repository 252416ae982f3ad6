// Light at some pixels of an image, chosen from coarse to fine, and interpolated at the others.
#pragma once

#include <coppice/core/image.hpp>
#include <coppice/core/parallel.hpp>
#include <coppice/gather/coherence.hpp>

namespace coppice {

/// How pixels are chosen.
enum class Sampling {
  relative,  ///< by a coherence error without units, which neither exposure nor grazing views change
  paper,     ///< by the coherence error of Filtering section 2.3
  uniform,   ///< the first grid alone
};

struct AdaptiveOptions {
  Sampling sampling = Sampling::relative;
  /// A pixel of the first finer grid is sampled where its error reaches this; of each finer one, where it
  /// reaches twice as much. 0: every pixel is sampled. Without meaning for Sampling::uniform.
  float epsilon = 0.07f;
  int step = 16;  ///< of the first grid, all of which is sampled: a power of two up to 128
  /// Light is divided by albedo before it is interpolated, and only between pixels of one material.
  bool use_materials = true;
  float diagonal = 1;  ///< of the scene's bounding box, metres; for Sampling::paper
};

/// As the paper has it, for a scene whose bounding box has this diagonal.
inline AdaptiveOptions paper_sampling(float diagonal) { return {Sampling::paper, 0.3f, 16, false, diagonal}; }

/// One pixel of step × step.
inline AdaptiveOptions uniform_sampling(int step) {
  return {.sampling = Sampling::uniform, .epsilon = 0, .step = step};
}

/// What sampling gave.
struct AdaptiveImage {
  Image radiance;                   ///< black where nothing is covered
  std::vector<std::uint8_t> steps;  ///< a pixel: step of the grid at which it was sampled; 0: interpolated
  std::size_t samples = 0;          ///< pixels sampled
};

namespace detail {

/// The image while it is made. `light` is radiance over divisors.
template <class Gather, Executor E>
class AdaptiveSampler {
 public:
  AdaptiveSampler(const GBuffer& buffer, const AdaptiveOptions& options, Gather& gather, const E& executor)
      : buffer_(buffer), options_(options), gather_(gather), executor_(executor) {
    COPPICE_ASSERT(buffer.pixels.size() == std::size_t(buffer.width) * std::size_t(buffer.height));
    COPPICE_ASSERT(options.step >= 1 && options.step <= 128 && (options.step & (options.step - 1)) == 0);
    result_.radiance = Image(buffer.width, buffer.height);
    result_.steps.assign(buffer.pixels.size(), 0);
    light_.assign(buffer.pixels.size(), vec3(0));
    if (options.sampling == Sampling::relative) bends_.assign(buffer.pixels.size(), vec3(0));
  }

  AdaptiveImage run() {
    sample_first_grid();
    float threshold = options_.epsilon;
    for (int step = options_.step / 2; step >= 1; step /= 2, threshold *= 2) refine(step, threshold);
    multiply_back();
    return std::move(result_);
  }

 private:
  static constexpr float lambda = 16;              // Filtering section 2.3
  static constexpr float least_share = 0.2f;       // of bilateral weights, below which pixels are sampled
  static constexpr float share_of_average = 0.1f;  // of the image, added to what errors are relative to

  vec3 divisor(std::size_t pixel) const {
    return options_.use_materials ? glm::max(buffer_.pixels[pixel].albedo, vec3(1e-3f)) : vec3(1);
  }

  /// Calls visit(x, y) for the covered pixels of a grid, a row in one piece; rows in parallel.
  template <class Visit>
  void for_each_on_grid(int step, Visit&& visit) const {
    const std::size_t rows = std::size_t((buffer_.height + step - 1) / step);
    executor_(rows, 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row)
        for (int x = 0, y = int(row) * step; x < buffer_.width; x += step)
          if (buffer_.has(x, y)) visit(x, y);
    });
  }

  void sample_first_grid() {
    const int step = options_.step;
    for_each_on_grid(step, [&](int x, int y) { result_.steps[buffer_.index(x, y)] = std::uint8_t(step); });
    gather_marked(step);
    double sum = 0, count = 0;
    for (const vec3& radiance : gathered_)
      if (is_finite(radiance)) sum += double(luminance(radiance)), ++count;
    average_ = count > 0 ? float(sum / count) : 0.0f;
  }

  /// Interpolates the pixels of this grid that the coarser ones lack, then samples those of too large an
  /// error.
  void refine(int step, float threshold) {
    if (options_.sampling == Sampling::relative)
      for_each_on_grid(2 * step, [&](int x, int y) {
        bends_[buffer_.index(x, y)] = bend_of_light(buffer_, x, y, 2 * step, options_.use_materials, light_);
      });
    for_each_on_grid(step, [&](int x, int y) {
      if (is_on_coarser_grid(x, y, step)) return;
      const std::size_t i = buffer_.index(x, y);
      const Parents parents = parents_of(buffer_, x, y, step);
      const Interpolated middle = interpolate(buffer_, i, parents, step, options_.use_materials, light_);
      light_[i] = middle.light;
      if (parents.count == 0 || !is_coherent(x, y, step, parents, middle, threshold))
        result_.steps[i] = std::uint8_t(step);
    });
    gather_marked(step);
  }

  /// False also for errors that are NaN.
  bool is_coherent(int x, int y, int step, const Parents& parents, const Interpolated& middle,
                   float threshold) const {
    switch (options_.sampling) {
      case Sampling::relative:
        return middle.share >= least_share && relative_error(x, y, step, parents, middle) < threshold;
      case Sampling::paper:
        return paper_error(x, y, step, parents) < threshold;
      case Sampling::uniform:
        break;
    }
    return true;
  }

  float paper_error(int x, int y, int step, const Parents& parents) const {
    const auto radiance = [&](std::size_t p) { return light_[p] * divisor(p); };
    return paper_geometry_error(buffer_, x, y, step, options_.diagonal) +
           lambda * paper_light_error(parents, radiance);
  }

  /// Change of the parents' light over the light itself, both times the pixel's albedo, so that what is dark
  /// in the image needs no care; plus the change of geometry, and the weight that parents lack.
  float relative_error(int x, int y, int step, const Parents& parents, const Interpolated& middle) const {
    const vec3 albedo = divisor(buffer_.index(x, y));
    const float change = luminance(albedo * change_of_light(parents, middle, light_, bends_));
    const float radiance = luminance(albedo * middle.light) + share_of_average * average_;
    return share_of(change, radiance) + relative_geometry_error(buffer_, x, y, step) + (1 - middle.share);
  }

  /// Asks for the radiance of all pixels marked with this step, row by row.
  void gather_marked(int step) {
    chosen_.clear();
    for (int y = 0; y < buffer_.height; y += step)
      for (int x = 0; x < buffer_.width; x += step)
        if (result_.steps[buffer_.index(x, y)] == step) chosen_.push_back(std::uint32_t(buffer_.index(x, y)));
    gathered_.assign(chosen_.size(), vec3(0));
    if (!chosen_.empty()) gather_(std::span<const std::uint32_t>(chosen_), std::span<vec3>(gathered_));
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      result_.radiance.pixels[chosen_[k]] = gathered_[k];
      light_[chosen_[k]] = gathered_[k] / divisor(chosen_[k]);
    }
    result_.samples += chosen_.size();
  }

  void multiply_back() {
    for_each_on_grid(1, [&](int x, int y) {
      const std::size_t i = buffer_.index(x, y);
      if (result_.steps[i] == 0) result_.radiance.pixels[i] = light_[i] * divisor(i);
    });
  }

  const GBuffer& buffer_;
  AdaptiveOptions options_;
  Gather& gather_;
  const E& executor_;
  float average_ = 0;  ///< luminance over the first grid
  std::vector<vec3> light_, bends_, gathered_;
  std::vector<std::uint32_t> chosen_;
  AdaptiveImage result_;
};

}  // namespace detail

/// Samples an image on ever finer grids (Filtering section 2.3): each pixel of a grid is sampled where it may
/// differ from its parents on the grid of twice the step, and otherwise interpolated between them; every grid
/// is judged by itself. `gather(std::span<const std::uint32_t> pixels, std::span<vec3> radiance)` is called
/// once a grid, with all covered pixels that it samples, in rising order; it sets the radiance of each.
/// Pixels of which no parent is covered are sampled always. NaN and infinity that `gather` gives stay in the
/// image; with Sampling::relative the pixels next to them on finer grids are sampled, otherwise they may
/// spread to these. The same bits for any executor. Cost beside `gather`: about 0.2 µs a pixel.
template <class Gather, Executor E>
AdaptiveImage sample_adaptively(const GBuffer& buffer, const AdaptiveOptions& options, Gather&& gather,
                                const E& executor) {
  return detail::AdaptiveSampler<std::remove_reference_t<Gather>, E>(buffer, options, gather, executor).run();
}

}  // namespace coppice
