#!/usr/bin/env bash
# Measures the release build: every benchmark to build/release/bench.json, then speed against error over the knobs to
# build/release/trade.csv. Arguments go to the benchmarks, for instance --benchmark_filter=merge.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=build/release

if [[ ! -x $build/bin/bench_coppice ]]; then
  echo "bench.sh: $build/bin/bench_coppice is missing; run ./build.sh bench, which builds it first" >&2
  exit 2
fi
# Medians of interleaved repetitions: what else the machine does falls on all alike.
"$build/bin/bench_coppice" --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true \
  --benchmark_min_time=0.1 --benchmark_color=false --benchmark_display_aggregates_only=true \
  --benchmark_out="$build/bench.json" --benchmark_out_format=json "$@"

if [[ -x $build/bin/trade ]]; then
  "$build/bin/trade" --scene assets/flight_helmet/flight_helmet.gltf --env assets/hdri/workshop.hdr --size 640x360 \
    --sigma 1,2,3 --cut-size 128,256,512 --out "$build/trade.csv"
fi
if [[ -x $build/bin/knobs ]]; then "$build/bin/knobs"; fi
