#!/usr/bin/env bash
# Renders the demo's animation, a knot that flies around the helmet while the environment turns, and prints what a frame
# costs. Needs the release programs (./build.sh demo builds them); writes to build/animation.
#
#   animation.sh [FRAMES] [more options of cut_relighting]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

frames="${1:-48}"
out=build/animation
mkdir -p "$out"
build/release/bin/cut_relighting --scene assets/flight_helmet/flight_helmet_moving.gltf --env assets/hdri/workshop.hdr \
  --size 640x360 --longest-edge 12 --animate --frames "$frames" --rotate-env 2.5 --out "$out/frame.exr" \
  --report "$out/report.json" "${@:2}"
python3 scripts/animation_cost.py "$out/report.json"
python3 scripts/contact_sheet.py "$out/sheet.png" --columns 4 --of 8 "$out"/frame.*.png
