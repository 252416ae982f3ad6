#!/usr/bin/env bash
# Measures the release build and writes one report, build/release/bench.md: frames from the paper's way to the
# library's against brute force, glossy materials, single choices, many lights by shadow rays, visibility cuts at equal
# error, the light of VPLs, spherical Gaussians, lights in a room, and every kernel beside its slow twin (also in
# build/release/bench.json). Arguments go to the benchmarks of kernels, for instance --benchmark_filter=merge.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=build/release
report=$build/bench.md

for program in frames knobs many_lights trade sg_relighting environment_fit bench_coppice; do
  if [[ ! -x $build/bin/$program ]]; then
    echo "bench.sh: $build/bin/$program is missing; run ./build.sh bench, which builds it first" >&2
    exit 2
  fi
done

"$build/bin/frames" | tee "$report"
"$build/bin/knobs" | tee -a "$report"
# Rooms full of lamps, which are made up; for a scene of your own: many_lights --scene FILE.glb.
"$build/bin/many_lights" | tee -a "$report"
printf '\n## Pieces of a visibility cut at equal error\n\n' | tee -a "$report"
SWEEP_SIZE="${SWEEP_SIZE:-192x108}" scripts/sweep.sh | tee -a "$report"
printf '\n## Gathering the light of VPLs\n' | tee -a "$report"
VPLS_SIZE="${VPLS_SIZE:-320x180}" scripts/vpls.sh | tee -a "$report"
printf '\n## Spherical Gaussians\n\n' | tee -a "$report"
"$build/bin/environment_fit" --tables fits assets/hdri/workshop.hdr | tee -a "$report"
GAUSSIANS_SIZE="${GAUSSIANS_SIZE:-160x90}" scripts/gaussians.sh | tee -a "$report"
printf '\n## Lights that move through a room\n\n' | tee -a "$report"
scripts/pca.sh | tee -a "$report"
printf '\n## Kernels\n\n```\n' | tee -a "$report"
# Medians of interleaved repetitions: what else the machine does falls on all alike.
"$build/bin/bench_coppice" --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true \
  --benchmark_min_time=0.1 --benchmark_color=false --benchmark_display_aggregates_only=true \
  --benchmark_out="$build/bench.json" --benchmark_out_format=json "$@" | tee -a "$report"
printf '```\n' | tee -a "$report"
echo "bench.sh: the report is $report" >&2
