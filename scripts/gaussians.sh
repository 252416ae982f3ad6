#!/usr/bin/env bash
# Measures relighting by spherical Gaussians: cones, error and time by placement, visibility and material against the sum
# over all lights, and time by triangles and peaks. Arguments: a scene and environment maps; without any, those that the
# project carries. GAUSSIANS_SIZE sets the image of the first part (320x180), GAUSSIANS_FRAME that of the second
# (640x360), GAUSSIANS_PARTS which are run (trade, frames). Writes Markdown to standard output and files to
# build/gaussians.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bin=build/release/bin
scene=${1:-assets/flight_helmet/flight_helmet.gltf}
if (($# > 0)); then shift; fi
maps=("$@")
if ((${#maps[@]} == 0)); then maps=(assets/hdri/workshop.hdr); fi
for program in trade sg_relighting; do
  if [[ ! -x $bin/$program ]]; then
    echo "gaussians.sh: $bin/$program is missing; run ./build.sh bench or ./build.sh demo, which build it first" >&2
    exit 2
  fi
done
out=build/gaussians
mkdir -p "$out"
parts=${GAUSSIANS_PARTS:-trade frames}

# Rays first: 128 a cone are all but exact, and tell what the placement costs; then what voxels add.
settings=cut:7:rays:rays=128,cut:13:rays:rays=128,cut:19:rays:rays=128
settings+=,cut:7:rays:rays=128:peaks=0,packed:7:rays:rays=128,packed:19:rays:rays=128
settings+=,packed:7:rays:rays=128:peaks=0,packed:7:rays:rays=128:lights,packed:7:rays:rays=128:warped
settings+=,paper:7:rays:rays=128:lights:warped:pyramid
settings+=,cut:7:voxels,cut:7:voxels:contact=0,cut:7:mips,packed:7:voxels
if [[ $parts == *trade* ]]; then
  for map in "${maps[@]}"; do
    name=$(basename "${scene%.*}")_$(basename "${map%.*}")
    printf '\n### %s\n\n' "$name"
    "$bin/trade" sg_relighting --scene "$scene" --env "$map" --size "${GAUSSIANS_SIZE:-320x180}" \
      --materials "${GAUSSIANS_MATERIALS:-lambert,phong:50,ggx:0.3}" --settings "$settings" --out "$out/$name.csv"
  done
fi

# The paper's Table 2: the same picture from more and more triangles, and from more and more peaks.
if [[ $parts == *frames* ]]; then
  map=${maps[${#maps[@]} - 1]}
  printf '\n### Triangles and peaks (%s)\n\n' "$(basename "${map%.*}")"
  echo '| Triangles | Peaks | Cones a point | Voxels built, s | Placement, ms | Visibility, ms | without contact, ms | Frame, ms |'
  echo '|---|---|---|---|---|---|---|---|'
  for triangles in 3000 30000 300000 900000; do
    ball=$out/ball_$triangles.glb
    python3 scripts/make_ball_scene.py "$ball" "$triangles"
    for peaks in 1 6 11; do
      for contact in 3 0; do
        "$bin/sg_relighting" --scene "$ball" --env "$map" --size "${GAUSSIANS_FRAME:-640x360}" --peaks "$peaks" --peak-share 0 \
          --contact "$contact" --frames 5 --threads 1 --out "$out/ball.exr" --report "$out/ball_$contact.json" \
          2>"$out/ball.log" || { cat "$out/ball.log" >&2; exit 1; }
      done
      python3 scripts/gaussian_frames.py "$out/ball_3.json" "$out/ball_0.json"
    done
  done
fi
