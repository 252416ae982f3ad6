#include <support/system.hpp>

namespace coppice::program {

float turn_of_frame(const SystemOptions& options, int frame) {
  return glm::radians(options.common.rotate_environment * float(options.frames > 1 ? frame : 1));
}

float time_of_frame(int frames, const Scene& scene, int frame) {
  return frames > 1 ? animation_duration(scene) * float(frame) / float(frames) : 0.0f;
}

std::vector<float> resolve_counts(const ShadingBuffer& buffer, const Raster& raster,
                                  std::span<const std::uint32_t> counts) {
  std::vector<vec3> values;
  for (const std::uint32_t c : counts) values.emplace_back(float(c));
  std::vector<float> means;
  for (const vec3& v : resolve(buffer, raster, values).pixels) means.push_back(v.x);
  return means;
}

Image add_emission(Image reflected, const DirectImage& direct) {
  for (std::size_t i = 0; i < reflected.pixels.size(); ++i) reflected.pixels[i] += direct.emission.pixels[i];
  return reflected;
}

}  // namespace coppice::program
