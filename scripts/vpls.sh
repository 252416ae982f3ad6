#!/usr/bin/env bash
# Measures how the light of VPLs is gathered: nodes, time and error by exponents, criterion and threshold, and what
# gathering only some pixels saves, against the sum over all VPLs. Arguments: a scene and, where it is lit from outside,
# an environment map; without any, the scene that the project carries. VPLS_SIZE sets the image (640x360), VPLS_DENSITY
# where VPLs lie (root-irradiance). Writes Markdown to standard output and CSV files to build/vpls.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

trade=build/release/bin/trade
scene=${1:-assets/flight_helmet/flight_helmet.gltf}
environment=${2:-}
if (($# == 0)); then environment=assets/hdri/workshop.hdr; fi
if [[ ! -x $trade ]]; then
  echo "vpls.sh: $trade is missing; run ./build.sh bench or ./build.sh demo, which build it first" >&2
  exit 2
fi
out=build/vpls
mkdir -p "$out"
name=$(basename "${scene%.*}")

measure() {
  local exponents=$1 suffix=$2
  shift 2
  "$trade" glossy_vpls --scene "$scene" ${environment:+--env "$environment"} --exponents "$exponents" \
    --size "${VPLS_SIZE:-640x360}" --density "${VPLS_DENSITY:-root-irradiance}" \
    --out "$out/${name}_${exponents/:/_}_$suffix.csv" "$@"
}

for exponents in 5:60 100:500; do
  printf '\n### %s, exponents %s\n\n' "$name" "$exponents"
  measure "$exponents" gather --points 4096 --gather bound:0.02,bound:0.01,bound:0.005,angle:0.05,angle:0.02
  printf '\nThe ways of the paper, and other trees:\n\n'
  measure "$exponents" ways --points 4096 --gather \
    bound:0.01:lengths,bound:0.01:kd,bound:0.01:uniform,angle:0.02:uniform,min-max:40:9:0.02,min-max:4:0.5:0.02
  printf '\nShadows, against all VPLs with their shadows:\n\n'
  measure "$exponents" traced --points 2048 --repeat 1 --gather traced:0.05,traced:0.02,energy:0.02
done
printf '\n### %s, exponents 5:60: only some pixels\n\n' "$name"
measure 5:60 pixels --points 2048 --gather bound:0.02,angle:0.02 \
  --pixels relative:0.07,relative:0.1,paper:0.3,uniform:2,uniform:4
printf '\n### %s, exponents 5:60: VPLs and bounces\n\n' "$name"
measure 5:60 counts --points 2048 --vpls 4096,8192,16384 --bounces 1,2 --gather bound:0.02
