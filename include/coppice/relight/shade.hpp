// Shading of points from merged clusters: Σ power · interpolated visibility · BRDF.
#pragma once

#include <coppice/shared/layout.h>

#include <coppice/brdf/with_brdf.hpp>
#include <coppice/relight/clusters.hpp>
#include <span>
#include <vector>

namespace coppice {

/// Rows that take a world direction to a point's local frame.
struct LocalFrame {
  vec3 tangent, bitangent, normal;
  explicit LocalFrame(const ShadingPoint& p)
      : tangent(p.tangent), bitangent(cross(p.normal, p.tangent)), normal(p.normal) {}

  static Lanes along(const vec3& axis, Lanes x, Lanes y, Lanes z) {
    return mul_add(Lanes(axis.x), x, mul_add(Lanes(axis.y), y, Lanes(axis.z) * z));
  }
};

/// Σ_k power_k · visibility_k · term_j, for the terms of one BRDF: nine sums, coloured once at the end.
class TermSums {
 public:
  template <int terms>
  void add(const BrdfTerms<Lanes>& t, Lanes visibility, Lanes red, Lanes green, Lanes blue) {
    const Lanes term[3] = {t.diffuse, t.specular, t.fresnel};
    for (int j = 0; j < terms; ++j) {
      const Lanes v = visibility * term[j];
      sums_[j][0] = mul_add(v, red, sums_[j][0]);
      sums_[j][1] = mul_add(v, green, sums_[j][1]);
      sums_[j][2] = mul_add(v, blue, sums_[j][2]);
    }
  }

  vec3 colour(const ShadingPoint& p, float scale) const {
    const auto sum = [this](int j) {
      return vec3(sum_of_lanes(sums_[j][0]), sum_of_lanes(sums_[j][1]), sum_of_lanes(sums_[j][2]));
    };
    return scale * (p.diffuse * sum(0) + p.specular * sum(1) + p.fresnel * sum(2));
  }

 private:
  Lanes sums_[3][3] = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
};

/// Radiance of one point from the clusters of its face (Cuts Eq. 5): the BRDF is evaluated at each cluster's
/// luminance-weighted mean direction, the visibility is the barycentric mean of the three receivers'.
/// `scale` turns the clusters' units of visibility into [0, 1].
inline vec3 shade_point(const ShadingPoint& point, const ClusterList& clusters, float scale) {
  return with_brdf(point, [&](const auto& brdf) {
    using B = std::decay_t<decltype(brdf)>;
    const LocalFrame frame(point);
    const Lanes w0 = point.weight_0, w1 = point.weight_1, w2 = 1 - point.weight_0 - point.weight_1;
    const auto load = [&](ClusterList::Field f, std::size_t i) { return Lanes::load(clusters.field(f) + i); };
    TermSums sums;
    for (std::size_t i = 0; i < clusters.padded_size(); i += Lanes::width) {
      const Lanes x = load(ClusterList::x, i), y = load(ClusterList::y, i), z = load(ClusterList::z, i);
      const Lanes visibility =
          mul_add(w0, load(ClusterList::visible_0, i),
                  mul_add(w1, load(ClusterList::visible_1, i), w2 * load(ClusterList::visible_2, i)));
      const auto terms =
          brdf(LocalFrame::along(frame.tangent, x, y, z), LocalFrame::along(frame.bitangent, x, y, z),
               LocalFrame::along(frame.normal, x, y, z));
      sums.add<B::terms>(terms, visibility, load(ClusterList::red, i), load(ClusterList::green, i),
                         load(ClusterList::blue, i));
    }
    return sums.colour(point, scale);
  });
}

/// Points sorted by face, the faces between receivers, and the pixel that each point colours.
struct ShadingBuffer {
  std::vector<ShadingPoint> points;
  std::vector<ShadingFace> faces;
  std::vector<std::uint32_t> pixels;  ///< a point

  std::uint32_t end_of(std::size_t face) const {
    return face + 1 < faces.size() ? faces[face + 1].first_point : std::uint32_t(points.size());
  }
};

/// Shades the points of faces [begin, end) into radiance[point], merging once a face, and counts each point's
/// clusters where cluster_count is not empty. Faces are independent: any split over threads gives the same
/// bits.
template <Quantised Value>
void shade_faces(const ShadingBuffer& buffer, const MaskedCuts<Value>& cuts, const FrameLighting& frame,
                 std::size_t begin, std::size_t end, std::span<vec3> radiance,
                 std::span<std::uint32_t> cluster_count) {
  ClusterList clusters;
  for (std::size_t f = begin; f < end; ++f) {
    merge_face(cuts, buffer.faces[f].receivers, frame, clusters);
    for (std::uint32_t p = buffer.faces[f].first_point; p < buffer.end_of(f); ++p) {
      radiance[p] = shade_point(buffer.points[p], clusters, 1 / quantised_one<Value>);
      if (!cluster_count.empty()) cluster_count[p] = std::uint32_t(clusters.size());
    }
  }
}

}  // namespace coppice
