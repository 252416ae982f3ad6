#!/usr/bin/env bash
# Puts the demo's table and picture into README.md, and pictures and the plot of glossy materials into docs/: run
# ./build.sh demo and ./build.sh bench first. The picture has four rays a pixel.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build/release/bin/cut_relighting --scene assets/flight_helmet/flight_helmet.gltf --env assets/hdri/workshop.hdr \
  --size 1280x720 --samples 4 --out build/demo/picture.exr
mkdir -p docs/images
cp build/demo/picture.png docs/images/flight_helmet.png
cp build/demo/trade.svg docs/images/trade.svg
cp build/demo/glossy.png docs/images/glossy_vpls.png
for visibility in voxels rays mips; do
  build/release/bin/sg_relighting --scene assets/flight_helmet/flight_helmet_moving.gltf --env assets/hdri/workshop.hdr \
    --size 480x270 --visibility "$visibility" --out "build/demo/gaussians_$visibility.exr"
done
python3 scripts/contact_sheet.py docs/images/gaussians.png --columns 3 --of 3 build/demo/gaussians_{voxels,rays,mips}.png
python3 scripts/make_room_scene.py build/demo/rooms.glb
build/release/bin/pca_transfer --scene build/demo/rooms.glb --path assets/rooms/lamp.json --size 480x270 --samples 4 \
  --frames 5 --surface-samples 20000 --clusters 24 --example-lights 2000 --out build/demo/rooms_doc.exr
python3 scripts/contact_sheet.py docs/images/rooms.png --columns 4 --of 4 build/demo/rooms_doc.000{0,1,3,4}.png
mkdir -p build/demo/rooms
build/release/bin/trade pca_transfer --scene build/demo/rooms.glb --visibility none --basis transport:20 --unseen 8 \
  --frame-lights 0 --size 320x180 --pictures build/demo/rooms --out build/demo/rooms/pictures.csv
cp build/demo/rooms/basis_vectors.png docs/images/basis_vectors.png
build/release/bin/cut_sizes docs/images/cut_sizes.png
build/release/bin/highlights docs/images/highlights.png
python3 scripts/plot_errors.py build/release/bench.md docs/images/glossy.svg
python3 scripts/readme.py write build/demo/table.md
