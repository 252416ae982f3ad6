#!/usr/bin/env bash
# Measures the table of the Cuts paper (Fig. 9): receivers, precomputation, storage, cut size, RMS and milliseconds a
# frame by the geometric and the data-driven tree, for each scene.
#
#   scripts/paper_table.sh [SCENES ENVIRONMENTS]
#
# Without arguments: the demo scene. With two folders also helmet_grey under city.hdr, kitchen_grey under workshop.hdr,
# the lights of dungeon_points and dungeon_area, and the bounce of kitchen, of which 8,192 lights and 50,000 receivers
# do. TABLE_SIZE (640x360) and TABLE_REPEAT (5) are the --size and --repeat of trade, TABLE_BETA (0.5) its --beta. Needs
# build/release/bin/trade; writes the rows to build/paper_table/table.csv and as Markdown to table.md there and to
# standard output.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

trade=build/release/bin/trade
out=build/paper_table

if (($# != 0 && $# != 2)); then
  echo "usage: scripts/paper_table.sh [SCENES ENVIRONMENTS]" >&2
  exit 2
fi
if [[ ! -x $trade ]]; then
  echo "paper_table.sh: $trade is missing; run ./build.sh demo, which builds it first" >&2
  exit 2
fi
mkdir -p "$out"
names=()

# measure NAME OPTION...: one scene and kind of light.
measure() {
  local name=$1
  shift
  echo "$name" >&2
  "$trade" --paper-table "$@" --size "${TABLE_SIZE:-640x360}" --repeat "${TABLE_REPEAT:-5}" \
    --beta "${TABLE_BETA:-0.5}" --out "$out/$name.csv" --report "$out/$name.json" >"$out/$name.md"
  names+=("$name")
}

# joined ENDING HEAD: the files of all scenes, the first HEAD lines of the first one only.
joined() {
  awk -v head="$2" 'NR <= head || FNR > head' "${names[@]/%/.$1}"
}

measure flight_helmet --scene assets/flight_helmet/flight_helmet.gltf --env assets/hdri/workshop.hdr
if (($# == 2)); then
  scenes=$1
  environments=$2
  measure helmet_grey --scene "$scenes/helmet_grey.glb" --env "$environments/city.hdr"
  measure kitchen_grey --scene "$scenes/kitchen_grey.glb" --env "$environments/workshop.hdr"
  measure dungeon_points --scene "$scenes/dungeon_points.glb" --lights scene
  measure dungeon_area --scene "$scenes/dungeon_area.glb" --lights scene
  measure kitchen --scene "$scenes/kitchen.glb" --lights indirect --bounces 8192 --max-receivers 50000
fi

cd "$out"
joined csv 1 >table.csv
joined md 2 | tee table.md
