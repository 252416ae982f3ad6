#!/usr/bin/env bash
# Measures relighting from PCA bases on lights that no basis was made for: shadows, indirect light and whole frames, by
# bytes, time and error. Argument: a scene; without one, the two rooms of make_room_scene.py. PCA_SAMPLES and
# PCA_CLUSTERS are lists separated by commas (12000 and 32), PCA_UNSEEN counts the lights (100), PCA_SIZE is that of the
# frames (320x180). Writes Markdown to standard output, and CSV, plot, report and pictures to build/pca.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

trade=build/release/bin/trade
if [[ ! -x $trade ]]; then
  echo "pca.sh: $trade is missing; run ./build.sh bench or ./build.sh demo, which build it first" >&2
  exit 2
fi
out=build/pca
mkdir -p "$out"
scene=${1:-$out/rooms.glb}
if (($# == 0)); then python3 scripts/make_room_scene.py "$scene"; fi
name=$(basename "${scene%.*}")
mkdir -p "$out/$name"

common=(--scene "$scene" --unseen "${PCA_UNSEEN:-100}" --size "${PCA_SIZE:-320x180}")
printf '\n### %s\n\n' "$name"
"$trade" pca_transfer "${common[@]}" --surface-samples "${PCA_SAMPLES:-12000}" --clusters "${PCA_CLUSTERS:-32}" \
  --pictures "$out/$name" --out "$out/$name.csv" --report "$out/$name.json"

printf '\n### %s: numbers of samples and clusters\n\n' "$name"
"$trade" pca_transfer "${common[@]}" --surface-samples 3000,12000 --clusters 8,32 --visibility lattice:40 \
  --basis transport:20 --out "$out/${name}_rooms.csv"

printf '\n### %s: the sparse form, small lights\n\n' "$name"
"$trade" pca_transfer "${common[@]}" --surface-samples 3000 --clusters 12 --visibility lattice:40,lattice:40:smooth \
  --light-size 0.1 --basis transport:20,paper:20,paper:20:sparse=0.2:bits=16 --frame-lights 2 \
  --out "$out/${name}_sparse.csv"
