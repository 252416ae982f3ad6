#!/usr/bin/env bash
# Measures relighting over all its knobs on several scenes and lightings, and compares the kinds of visibility cuts.
#
#   scripts/sweep.sh [SCENE:ENVIRONMENT[:DEGREES]...]
#
# Without arguments: the demo scene under its environment, turned four ways. SWEEP_SIZE (320x180) and SWEEP_REPEAT (1)
# are the --size and --repeat of trade. Needs build/release/bin/trade; writes to build/sweep.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

trade=build/release/bin/trade
out=build/sweep
knobs=(--sigma 0.7,1,1.4,2,2.8,4 --cut-size 32,64,128,256
  --cuts uniform-threshold,uniform-optimal,cosine-threshold,cosine-optimal
  --lobes sampled,filtered,refined --visibility-only
  --size "${SWEEP_SIZE:-320x180}" --repeat "${SWEEP_REPEAT:-1}")

lightings=("$@")
if ((${#lightings[@]} == 0)); then
  for degrees in 0 90 180 270; do
    lightings+=("assets/flight_helmet/flight_helmet.gltf:assets/hdri/workshop.hdr:$degrees")
  done
fi

if [[ ! -x $trade ]]; then
  echo "sweep.sh: $trade is missing; run ./build.sh bench, which builds it first" >&2
  exit 2
fi
mkdir -p "$out"
parts=()
for lighting in "${lightings[@]}"; do
  IFS=: read -r scene environment degrees <<<"$lighting"
  if [[ -z $scene || -z $environment ]]; then
    echo "sweep.sh: '$lighting' is not SCENE:ENVIRONMENT[:DEGREES]" >&2
    exit 2
  fi
  part=$out/${#parts[@]}
  echo "$scene under $environment, turned by ${degrees:-0} degrees" >&2
  "$trade" --scene "$scene" --env "$environment" --rotate-env "${degrees:-0}" "${knobs[@]}" \
    --out "$part.csv" --report "$part.json" >"$part.md"
  parts+=("$part.csv")
done

# One header, then the rows of all.
awk 'NR == 1 || FNR > 1' "${parts[@]}" >"$out/sweep.csv"
python3 scripts/nodes_at_equal_error.py "$out/sweep.csv"
