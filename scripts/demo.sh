#!/usr/bin/env bash
# Renders the demo scene at three operating points, and at the paper's way of cutting for comparison, and prints what
# they cost and how far off they are. Needs the release programs (./build.sh demo builds them); writes to build/demo.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

out=build/demo
mkdir -p "$out"
scene=(--scene assets/flight_helmet/flight_helmet.gltf --env assets/hdri/workshop.hdr --size 1280x720)

build/release/bin/trade "${scene[@]}" --points 3:32,2:64,1:128,2:256:uniform-threshold:sampled \
  --images "$out/helmet" --out "$out/trade.csv" --report "$out/trade.json" | tee "$out/table.md"

# The same helmet on its stand in glossy paint: what its parts send each other, twice, with shadows.
build/release/bin/glossy_vpls "${scene[@]:0:4}" --size 640x360 --exponents 5:60 --bounces 2 --visibility traced \
  --out "$out/glossy.exr" --report "$out/glossy.json"

# Light, materials and shape change at once, and nothing is precomputed: four frames of the knot that flies by.
build/release/bin/sg_relighting --scene assets/flight_helmet/flight_helmet_moving.gltf --env assets/hdri/workshop.hdr \
  --size 640x360 --rotate-env 30 --animate --frames 4 --roughness-to 0.2 --out "$out/gaussians.exr" \
  --report "$out/gaussians.json"

# A lamp goes from one room through a door into the next; shadows and bounces come from bases computed once.
python3 scripts/make_room_scene.py "$out/rooms.glb"
build/release/bin/pca_transfer --scene "$out/rooms.glb" --path assets/rooms/lamp.json --size 640x360 --frames 4 \
  --surface-samples 12000 --clusters 16 --lattice-points 1200 --example-lights 1000 --out "$out/rooms.exr" \
  --report "$out/rooms.json"

cat <<END

Images and measurements are in $out:
  helmet_sigma2_64_cosine-optimal_refined.png
                          the default operating point, tone-mapped; the .exr beside it holds radiance and the reference
  helmet_reference.png    all lights
  trade.svg, trade.csv    time against error
  glossy.png              two glossy bounces with shadows; the .exr beside it holds direct and indirect light apart
  gaussians.000?.png      four frames in which map, materials and a knot all change, by spherical Gaussians
  rooms.000?.png          a lamp on its way through two rooms, by PCA bases; direct and indirect light apart in the .exr
  trade.json              settings, counts, times and errors
END
