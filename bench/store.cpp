// Visibility to disk and back.
#include <coppice/store/store.hpp>
#include <filesystem>

#include "check.hpp"
#include "demo.hpp"

namespace coppice::bench {
namespace {

/// The demo's cuts of usual fineness, without the mesh.
StoredVisibility<std::uint8_t> visibility() {
  const CutRelighting<>& relighting = Demo::get().relighting;
  StoredVisibility<std::uint8_t> v;
  v.tree = relighting.tree();
  for (const vec3& d : relighting.directions()) v.lights.push_back(vec4(d, 0));
  v.receivers.assign(relighting.receivers().begin(), relighting.receivers().end());
  v.cuts = relighting.cuts(weighted + usual);
  return v;
}

std::filesystem::path path() { return std::filesystem::temp_directory_path() / "coppice-bench-store.h5"; }

/// Bytes in memory.
std::size_t decoded_bytes(const StoredVisibility<std::uint8_t>& v) {
  return v.cuts.byte_count() + v.receivers.size() * sizeof(Receiver) + v.lights.size() * sizeof(vec4) +
         v.tree.light_of_leaf.size() * 12;
}

void write(benchmark::State& state) {
  const auto v = visibility();
  for (auto _ : state) write_store(path(), v);
  state.SetBytesProcessed(std::int64_t(state.iterations() * decoded_bytes(v)));
  state.counters["bytes_per_receiver"] =
      double(std::filesystem::file_size(path())) / double(v.receivers.size());
  std::filesystem::remove(path());
}
BENCHMARK(write)->Name("store/write")->Unit(benchmark::kMillisecond);

void read(benchmark::State& state) {
  const auto v = visibility();
  write_store(path(), v);
  const auto copy = read_store<std::uint8_t>(path());
  const bool same = std::ranges::equal(copy.cuts.masks(), v.cuts.masks()) &&
                    std::ranges::equal(copy.cuts.values(), v.cuts.values());
  if (agrees(state, same ? 0 : 1, 0))
    for (auto _ : state) benchmark::DoNotOptimize(read_store<std::uint8_t>(path()));
  state.SetBytesProcessed(std::int64_t(state.iterations() * decoded_bytes(v)));
  std::filesystem::remove(path());
}
BENCHMARK(read)->Name("store/read")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace coppice::bench
