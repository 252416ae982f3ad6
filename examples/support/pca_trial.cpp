#include <support/pca_trial.hpp>
//
#include <coppice/core/stopwatch.hpp>
#include <coppice/pca/sparse_rows.hpp>

namespace coppice::program {
namespace {

/// The library's: patterns on receiver clusters.
template <class Value>
class PatternTrial : public TransferTrial {
 public:
  explicit PatternTrial(LightTransfer<Value> transfer) : transfer_(std::move(transfer)) {}

  void indirect(std::span<const float> grey, std::span<vec3> out, Stages& stages) const override {
    Stopwatch watch;
    std::vector<float> coefficients(3 * transfer_.coefficient_count());
    project_grey(transfer_, grey, vec3(1), Serial(), coefficients);
    stages["projection"] = 1e3 * watch.lap();
    std::vector<float> weights(3 * transfer_.pattern_count());
    mix(transfer_, coefficients, Serial(), weights);
    stages["transfer"] = 1e3 * watch.lap();
    expand(transfer_, weights, Serial(), out);
    stages["expansion"] = 1e3 * watch.lap();
  }
  std::size_t bytes() const override { return transfer_.bytes(); }

 private:
  LightTransfer<Value> transfer_;
};

/// The paper's: a row of the matrix a sample, of which the largest entries stay (PCA section 4.4).
template <class Value>
class SparseTrial : public TransferTrial {
 public:
  /// `projection`: the basis, with any patterns.
  SparseTrial(LightTransfer<Value> projection, SparseRows<Value> rows)
      : projection_(std::move(projection)), rows_(std::move(rows)) {}

  void indirect(std::span<const float> grey, std::span<vec3> out, Stages& stages) const override {
    Stopwatch watch;
    std::vector<float> coefficients(3 * projection_.coefficient_count());
    project_grey(projection_, grey, vec3(1), Serial(), coefficients);
    stages["projection"] = 1e3 * watch.lap();
    for (std::size_t i = 0; i < out.size(); ++i) {  // white light: all channels have the same coefficients
      float sums[3] = {0, 0, 0};
      for (std::size_t e = rows_.begin(i); e < rows_.begin(i + 1); ++e)
        sums[rows_.columns[e] % 3] += float(rows_.values[e]) * coefficients[rows_.columns[e] / 3];
      out[i] = rows_.scales[i] * vec3(sums[0], sums[1], sums[2]);
    }
    stages["transfer"] = 1e3 * watch.lap();
  }
  std::size_t bytes() const override {
    return projection_.projection.bytes() + projection_.offsets.size() * sizeof(float) + rows_.bytes();
  }

 private:
  LightTransfer<Value> projection_;
  SparseRows<Value> rows_;
};

template <class Value>
std::unique_ptr<TransferTrial> trial_of(const TransferSetting& setting, const SolvedBasis& solved,
                                        const TrialRoom& room) {
  CompressionOptions compression;
  compression.rank = setting.sparse ? 1 : setting.options.receiver_rank;
  LightTransfer<Value> transfer = compress_transfer<Value>(room.samples, solved.basis, solved.matrix,
                                                           room.examples, room.threads, compression);
  if (!setting.sparse) return std::make_unique<PatternTrial<Value>>(std::move(transfer));
  return std::make_unique<SparseTrial<Value>>(std::move(transfer),
                                              sparsify<Value>(solved.matrix, *setting.sparse));
}

}  // namespace

SolvedBasis solve_basis(const TransferSetting& setting, const TrialRoom& room) {
  LightBasisOptions options;
  options.rank = setting.options.rank;
  const LightBasisKind kind = setting.options.basis;
  SolvedBasis solved;
  solved.basis = kind == LightBasisKind::transport_aware
                     ? transport_aware_basis(room.samples, room.examples, room.probes, room.threads, options)
                     : principal_light_basis(room.samples, room.examples, kind, room.threads, options);
  TransferMatrixOptions matrix;
  matrix.bounces = room.solver.options;
  matrix.mean = setting.mean;
  solved.matrix = transfer_matrix(room.solver.transport, room.samples, solved.basis, room.threads, matrix);
  return solved;
}

std::unique_ptr<TransferTrial> make_trial(const TransferSetting& setting, const SolvedBasis& solved,
                                          const TrialRoom& room) {
  return setting.options.bits == 16 ? trial_of<std::int16_t>(setting, solved, room)
                                    : trial_of<std::int8_t>(setting, solved, room);
}

}  // namespace coppice::program
