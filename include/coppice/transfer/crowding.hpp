// Takes out the most crowded candidates until those that are left lie evenly.
#pragma once

#include <coppice/light/thin_samples.hpp>
#include <coppice/transfer/near_samples.hpp>

namespace coppice::detail {

/// Weighted sample elimination as `Elimination` does it (Yuksel 2015, Eq. 2 and 5), of candidates that each
/// have a room of their own (m²); all neighbours that face alike count, found on all threads.
class Crowding {
 public:
  template <Executor E>
  Crowding(std::span<const SurfaceSample> candidates, std::span<const float> room, std::size_t count,
           const E& executor)
      : alive_(candidates.size(), true) {
    COPPICE_ASSERT(room.size() == candidates.size());
    for (const float each : room) reach_.push_back(float(2 * even_radius(double(each), 1)));
    const double ratio = double(count) / double(candidates.size());
    nearest_ = float(0.65 * (1 - std::pow(std::min(1.0, ratio), 1.5)));
    if (!candidates.empty()) find_neighbours(candidates, executor);
  }

  /// Indices of those that are left, ascending.
  std::vector<std::uint32_t> run(std::size_t count) {
    using Entry = std::pair<float, std::uint32_t>;  // crowding only falls, so an old one is an upper bound
    std::vector<Entry> entries;
    for (std::uint32_t i = 0; i < alive_.size(); ++i) entries.emplace_back(crowding(i), i);
    std::priority_queue<Entry> queue(std::less<Entry>(), std::move(entries));
    for (std::size_t left = alive_.size(); left > count;) {
      const auto [bound, i] = queue.top();
      queue.pop();
      if (const float now = crowding(i); now < bound)
        queue.emplace(now, i);
      else
        alive_[i] = false, --left;
    }
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < alive_.size(); ++i)
      if (alive_[i]) kept.push_back(i);
    return kept;
  }

 private:
  struct Neighbour {
    std::uint32_t sample;
    float weight;
  };

  /// Pieces of 1,024 candidates, each with a list of its own, so that the order is always the same.
  template <Executor E>
  void find_neighbours(std::span<const SurfaceSample> candidates, const E& executor) {
    constexpr std::size_t piece = 1024;
    const NearSamples near(candidates, *std::ranges::max_element(reach_));
    lists_.resize((candidates.size() + piece - 1) / piece);
    ends_.resize(candidates.size());
    executor(lists_.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t l = begin; l < end; ++l)
        for (std::size_t i = l * piece; i < std::min(candidates.size(), (l + 1) * piece); ++i) {
          list_neighbours(candidates, near, std::uint32_t(i), lists_[l]);
          ends_[i] = std::uint32_t(lists_[l].size());
        }
    });
  }

  void list_neighbours(std::span<const SurfaceSample> candidates, const NearSamples& near, std::uint32_t i,
                       std::vector<Neighbour>& list) const {
    const float widest = 0.5f * (reach_[i] + near.reach());
    near.for_each_within(candidates[i].position, widest, [&](std::uint32_t k, float distance2) {
      const float reach = 0.5f * (reach_[i] + reach_[k]);
      if (k != i && distance2 < reach * reach && faces_alike(candidates[i], candidates[k]))
        list.push_back({k, weight(std::sqrt(distance2) / reach)});
    });
  }

  /// Eq. 2 with α = 8; distance over reach.
  float weight(float distance) const {
    const float w = 1 - std::max(distance, nearest_), w2 = w * w, w4 = w2 * w2;
    return w4 * w4;
  }

  float crowding(std::uint32_t i) const {
    const std::vector<Neighbour>& list = lists_[i / 1024];
    float sum = 0;
    for (std::uint32_t k = i % 1024 == 0 ? 0 : ends_[i - 1]; k < ends_[i]; ++k)
      if (alive_[list[k].sample]) sum += list[k].weight;
    return sum;
  }

  std::vector<bool> alive_;
  std::vector<float> reach_;  ///< 2 r_max, by candidate
  float nearest_ = 0;         ///< Eq. 5: r_min / r_max
  std::vector<std::vector<Neighbour>> lists_;
  std::vector<std::uint32_t> ends_;  ///< a candidate: in its piece's list
};

}  // namespace coppice::detail
