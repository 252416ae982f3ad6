// Adaptive sampling one pixel after the other: the slow twin of sample_adaptively.
#pragma once

#include <coppice/gather/adaptive.hpp>
#include <optional>

namespace coppice::reference {

/// The image by recursion: the light of a pixel asks for that of its parents, and these for that of theirs,
/// up to the first grid. Of a pair of pixels it takes weight and distances as the twin does, all else is its
/// own. `gather(pixel)` gives radiance. Cost: memory and calls for each pixel, no threads.
template <class Gather>
class AdaptiveByPixel {
 public:
  AdaptiveByPixel(const GBuffer& buffer, const AdaptiveOptions& options, Gather gather)
      : buffer_(buffer), options_(options), gather_(gather), light_(buffer.pixels.size()) {
    result_.radiance = Image(buffer.width, buffer.height);
    result_.steps.assign(buffer.pixels.size(), 0);
    average_ = average_of_first_grid();
  }

  AdaptiveImage image() {
    for (int y = 0; y < buffer_.height; ++y)
      for (int x = 0; x < buffer_.width; ++x) {
        const std::size_t i = buffer_.index(x, y);
        if (!buffer_.pixels[i].covered) continue;
        const vec3 light = light_at({x, y});
        if (result_.steps[i] == 0) result_.radiance.pixels[i] = light * divisor(i);
      }
    return result_;
  }

 private:
  using Place = glm::ivec2;

  /// A parent, and its bilateral weight.
  struct Weighted {
    Place place;
    float weight;
  };

  const GBufferPixel& at(Place p) const { return buffer_.pixels[buffer_.index(p.x, p.y)]; }
  bool exists(Place p) const { return buffer_.has(p.x, p.y); }

  vec3 divisor(std::size_t i) const {
    vec3 result(1);
    for (int c = 0; c < 3 && options_.use_materials; ++c)
      result[c] = std::max(buffer_.pixels[i].albedo[c], 1e-3f);
    return result;
  }

  float average_of_first_grid() {
    double sum = 0, count = 0;
    for (int y = 0; y < buffer_.height; y += options_.step)
      for (int x = 0; x < buffer_.width; x += options_.step) {
        if (!exists({x, y})) continue;
        light_at({x, y});
        const vec3& radiance = result_.radiance.at(x, y);
        if (is_finite(radiance)) sum += double(luminance(radiance)), count += 1;
      }
    return count > 0 ? float(sum / count) : 0.0f;
  }

  /// The coarsest grid that has the pixel.
  int step_of(Place p) const {
    int step = options_.step;
    while (p.x % step != 0 || p.y % step != 0) step /= 2;
    return step;
  }

  vec3 light_at(Place p) {
    const std::size_t i = buffer_.index(p.x, p.y);
    if (!light_[i]) {
      const int step = step_of(p);
      const auto parents = parents_of(p, step);
      const bool is_sampled = step == options_.step || parents.empty() || !is_coherent(p, step, parents);
      light_[i] = is_sampled ? sample(i, step) : mean(parents, p, step);
    }
    return *light_[i];
  }

  vec3 sample(std::size_t i, int step) {
    ++result_.samples;
    result_.steps[i] = std::uint8_t(step);
    result_.radiance.pixels[i] = gather_(std::uint32_t(i));
    return result_.radiance.pixels[i] / divisor(i);
  }

  /// Along the axes in which the pixel is not on the coarser grid, one step to both sides.
  std::vector<Weighted> parents_of(Place p, int step) const {
    std::vector<Weighted> parents;
    if (step == options_.step) return parents;
    for (const int dy : {-step, 0, step})
      for (const int dx : {-step, 0, step}) {
        const Place q = p + Place(dx, dy);
        const bool is_nearest = (dx != 0) == (p.x % (2 * step) != 0) && (dy != 0) == (p.y % (2 * step) != 0);
        if (is_nearest && exists(q)) parents.push_back({q, weight(p, q, step)});
      }
    return parents;
  }

  float weight(Place p, Place q, int step) const {
    return bilateral_weight(buffer_, at(p), at(q), step, options_.use_materials);
  }

  /// Sum of the parents' bilateral weights over that of their bilinear ones.
  float share(const std::vector<Weighted>& parents, Place p, int step) const {
    float sum = 0;
    for (const Weighted& parent : parents) sum += parent.weight;
    return sum / (p.x % (2 * step) != 0 && p.y % (2 * step) != 0 ? 4.0f : 2.0f);
  }

  vec3 mean(const std::vector<Weighted>& parents, Place p, int step) {
    const bool is_bilateral = share(parents, p, step) > 1e-6f;
    vec3 light(0);
    float before = 0;
    for (const Weighted& parent : parents) {
      const float w = is_bilateral ? parent.weight : 1.0f;
      if (w <= 0) continue;
      before += w;
      light += (light_at(parent.place) - light) * (w / before);
    }
    return light;
  }

  bool is_coherent(Place p, int step, const std::vector<Weighted>& parents) {
    if (options_.sampling == Sampling::uniform) return true;
    const float threshold = options_.epsilon * float(options_.step / 2 / step);
    if (options_.sampling == Sampling::paper) return paper_error(p, step, parents) < threshold;
    return share(parents, p, step) >= 0.2f && relative_error(p, step, parents) < threshold;
  }

  float paper_error(Place p, int step, const std::vector<Weighted>& parents) {
    float geometry = 0, light = 0;
    for (const Place d : {Place(1, 0), Place(-1, 0), Place(0, 1), Place(0, -1)}) {
      if (!exists(p + step * d)) continue;
      const GBufferPixel &here = at(p), there = at(p + step * d);
      geometry = std::max(geometry, length(there.position - here.position) / (options_.diagonal / 2) +
                                        detail::normal_distance(there.normal, here.normal));
    }
    const auto radiance = [&](Place q) { return luminance(light_at(q) * divisor(buffer_.index(q.x, q.y))); };
    for (std::size_t j = 0; j < parents.size(); ++j)
      for (std::size_t k = j + 1; k < parents.size(); ++k)
        light += std::fabs(radiance(parents[j].place) - radiance(parents[k].place));
    return geometry + 16 * light;
  }

  float relative_error(Place p, int step, const std::vector<Weighted>& parents) {
    float geometry = 0;
    for (const Place d : {Place(1, 0), Place(-1, 0), Place(0, 1), Place(0, -1)}) {
      if (!exists(p + step * d)) continue;
      const GBufferPixel &here = at(p), there = at(p + step * d);
      const float plane = std::min(plane_distance(buffer_, here, there, step), 1.0f);
      geometry = std::max(geometry, 0.1f * (plane + detail::normal_distance(there.normal, here.normal)));
    }
    const vec3 albedo = divisor(buffer_.index(p.x, p.y));
    const float change = luminance(albedo * (0.5f * spread(parents) + bend(parents, step)));
    const float radiance = luminance(albedo * mean(parents, p, step)) + 0.1f * average_;
    const float relative = change / std::max(radiance, std::numeric_limits<float>::min());
    return relative + geometry + (1 - share(parents, p, step));
  }

  /// A channel: the largest difference of any two parents with some weight.
  vec3 spread(const std::vector<Weighted>& parents) {
    vec3 most(0);
    for (const Weighted& a : parents)
      for (const Weighted& b : parents)
        if (a.weight > 0.02f && b.weight > 0.02f)
          most = glm::max(most, light_at(a.place) - light_at(b.place));
    return most;
  }

  /// A channel: the largest second difference at a parent with some weight, along x or y, over alike pixels.
  vec3 bend(const std::vector<Weighted>& parents, int step) {
    vec3 most(0);
    for (const Weighted& parent : parents)
      for (const Place d : {Place(2 * step, 0), Place(0, 2 * step)}) {
        const Place p = parent.place;
        if (parent.weight <= 0.02f || !exists(p - d) || !exists(p + d)) continue;
        if (weight(p, p - d, 2 * step) < 0.5f || weight(p, p + d, 2 * step) < 0.5f) continue;
        const vec3 middle = light_at(p);
        most = glm::max(most, glm::abs((light_at(p - d) - middle) + (light_at(p + d) - middle)));
      }
    return most;
  }

  const GBuffer& buffer_;
  AdaptiveOptions options_;
  Gather gather_;
  std::vector<std::optional<vec3>> light_;
  AdaptiveImage result_;
  float average_ = 0;  ///< luminance over the first grid, set before any other pixel is asked for
};

/// sample_adaptively, with `gather(pixel)` one pixel at a time.
template <class Gather>
AdaptiveImage sample_adaptively(const GBuffer& buffer, const AdaptiveOptions& options, Gather gather) {
  return AdaptiveByPixel<Gather>(buffer, options, gather).image();
}

}  // namespace coppice::reference
