#include "refusal.hpp"
#include "room.hpp"

namespace coppice::store {
namespace {

class Checker {
 public:
  Checker(const StoredRoom& room, const std::string& start, const std::string& remedy)
      : ends_(room.samples.ends), samples_(room.samples.samples), start_(start), remedy_(remedy) {}

  void check_samples() const {
    require(std::ranges::is_sorted(ends_) && (ends_.empty() ? 0 : ends_.back()) == samples_.size(),
            "the clusters' ends are not ascending to the number of samples");
    require(std::ranges::all_of(samples_, [](const SurfaceSample& s) { return s.area >= 0; }),
            "a sample has an area below 0");
  }

  void check(std::monostate) const {}

  template <class Integer>
  void check(const LatticeVisibility<Integer>& v) const {
    check_lattice(v.lattice);
    require(v.ends == ends_ && v.clusters.size() == ends_.size(),
            "visibility and samples have other clusters");
    for (std::size_t c = 0; c < ends_.size(); ++c) check_cluster(v.clusters[c], v.rank, v.lattice.count(), c);
  }

  template <class Value>
  void check(const LightTransfer<Value>& t) const {
    require(t.sample_ends == ends_, "transfer and samples have other clusters");
    check_fields(t.projection, "projection");
    check_fields(t.patterns, "patterns");
    const std::size_t coefficients = t.projection.count(), width = t.coefficient_count();
    require(width == coefficients || width == coefficients + 1,
            "the mixes have not as many columns as there are coefficients");
    for (const auto& mix : t.mix)
      require(mix.width == width && mix.count() == t.pattern_count() &&
                  mix.values.size() == t.pattern_count() * width,
              "a mix has not a row for each pattern and a column for each coefficient");
    require(t.offsets.empty() || t.offsets.size() == coefficients,
            "there is not one offset for each coefficient");
  }

 private:
  void require(bool condition, const char* problem) const {
    if (!condition) throw Refusal(start_ + problem, remedy_);
  }

  std::size_t size(std::size_t cluster) const {
    return ends_[cluster] - (cluster == 0 ? 0 : ends_[cluster - 1]);
  }

  void check_lattice(const LightLattice& lattice) const {
    constexpr int most = 1 << 30;  // so that the cells about a lattice have numbers, too
    for (int k = 0; k < 3; ++k)
      require(lattice.size[k] >= 0 && lattice.size[k] < most, "the lattice has an impossible size");
    const std::size_t layer = std::size_t(lattice.size.x) * std::size_t(lattice.size.y);
    const auto deep = std::size_t(lattice.size.z);
    require(layer == 0 || deep <= ~std::size_t{0} / layer, "the lattice has an impossible size");
    require(lattice.numbers.size() == layer * deep, "the lattice has not a number for each of its places");
    require(lattice.spacing > 0 || lattice.numbers.empty(), "the lattice has no spacing");
    require(!lattice.numbers.empty() || lattice.count() == 0, "the lattice has points and no size");
    require(
        std::ranges::all_of(lattice.numbers,
                            [&](std::uint32_t n) { return n == LightLattice::none || n < lattice.count(); }),
        "the lattice names points that are not there");
  }

  void check_index(const FeatureIndex& index, std::size_t points) const {
    require(index.bits.size() == (points + 31) / 32 && index.before.size() == index.bits.size(),
            "a feature index has not a bit for each lattice point");
    require(points % 32 == 0 || index.bits.back() >> (points % 32) == 0,
            "a feature index has bits behind the lattice points");
    std::uint64_t before = 0;
    for (std::size_t w = 0; w < index.bits.size(); ++w) {
      require(index.before[w] == before, "a feature index does not count its own bits");
      before += std::uint64_t(std::popcount(index.bits[w]));
    }
  }

  template <class Integer>
  void check_cluster(const LatticeCluster<Integer>& cluster, std::size_t rank, std::size_t points,
                     std::size_t c) const {
    check_index(cluster.index, points);
    require(cluster.scales.size() == rank, "a cluster's visibility has not a scale for each component");
    require(cluster.coefficients.size() == rank * size(c),
            "a cluster's visibility has not as many coefficients as samples");
    require(cluster.rows.size() == rank * row_count(cluster.index.bits),
            "a cluster's visibility has not the rows that its index tells of");
  }

  /// `name`: of the fields, in plain words.
  template <class Value>
  void check_fields(const ClusterFields<Value>& fields, const std::string& name) const {
    const auto hold = [&](bool condition, const char* problem) {
      if (!condition) require(false, ("the " + name + problem).c_str());
    };
    hold(fields.ends.size() == ends_.size() && std::ranges::is_sorted(fields.ends) &&
             (ends_.empty() ? 0 : fields.ends.back()) == fields.count(),
         ": their ends are not ascending to their number, one for each cluster");
    hold(fields.first.size() == (ends_.empty() ? 0 : fields.count() + 1),
         ": not every one of them has a place");
    std::uint64_t at = 0;
    for (std::size_t c = 0; c < ends_.size(); ++c)
      for (std::size_t f = fields.begin(c); f < fields.end(c); ++f, at += size(c))
        hold(fields.first[f] == at, ": one is not as long as its cluster has samples");
    hold((ends_.empty() || fields.first.back() == at) && fields.values.size() == at,
         ": their values are not as many as they need");
  }

  const std::vector<std::uint32_t>& ends_;
  const std::vector<SurfaceSample>& samples_;
  const std::string &start_, &remedy_;
};

}  // namespace

void require_invariants(const StoredRoom& room, const std::string& start, const std::string& remedy) {
  const Checker checker(room, start, remedy);
  checker.check_samples();
  std::visit([&](const auto& visibility) { checker.check(visibility); }, room.visibility);
  std::visit([&](const auto& transfer) { checker.check(transfer); }, room.transfer);
}

}  // namespace coppice::store
