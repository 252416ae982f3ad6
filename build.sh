#!/usr/bin/env bash
# Builds Coppice on Debian 12 and shows, tests or measures it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

packages=(
  cmake ninja-build g++ ccache python3
  libglm-dev libhwy-dev
  libembree-dev libtbb-dev
  libopenexr-dev libstb-dev
  libtinygltf-dev nlohmann-json3-dev
  libeigen3-dev
  libhdf5-dev libdeflate-dev python3-h5py
  libvulkan-dev glslc mesa-vulkan-drivers vulkan-validationlayers libspirv-cross-c-shared-dev
  libnanoflann-dev libcli11-dev
  doctest-dev librapidcheck-dev libbenchmark-dev
)

fuzz_packages=(clang libclang-rt-dev)

usage() {
  cat <<'END'
usage: ./build.sh demo|test|bench|fuzz

  demo   builds the programs and renders with them
  test   builds and runs the tests, then once more with address and undefined-behaviour sanitizers
  bench  builds and runs the benchmarks
  fuzz   builds the fuzz targets with Clang and runs each for a minute, or the seconds that are named

Each first installs the Debian packages that are missing. Builds go to build/.
END
}

missing_packages() {
  local package
  for package in "${packages[@]}"; do
    if [[ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" != installed ]]; then
      echo "$package"
    fi
  done
}

as_root() {
  if ((EUID == 0)); then "$@"; else sudo "$@"; fi
}

install_packages() {
  if ! command -v apt-get >/dev/null; then
    echo "build.sh: no apt here; needed are what Debian calls ${packages[*]}" >&2
    return
  fi
  local -a missing
  mapfile -t missing < <(missing_packages)
  if ((${#missing[@]} == 0)); then return; fi
  echo "build.sh: installing ${missing[*]}" >&2
  as_root apt-get update
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"
}

prepare() {
  install_packages
  local jobs
  jobs="$(nproc)"
  export CMAKE_BUILD_PARALLEL_LEVEL="$jobs" CTEST_PARALLEL_LEVEL="$jobs"
  if command -v ccache >/dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
}

# build PRESET [TARGET...]: everything where no target is named.
build() {
  cmake --preset "$1"
  cmake --build --preset "$1" ${2:+--target "${@:2}"}
}

demo() {
  build release cut_relighting glossy_vpls pca_transfer sg_relighting trade first_light
  scripts/demo.sh "$@"
}

run_tests() {
  build release
  ctest --preset release
  build asan-ubsan
  ctest --preset asan-ubsan
}

bench() {
  build release bench_coppice frames highlights knobs many_lights trade pca_transfer sg_relighting environment_fit
  scripts/bench.sh "$@"
}

fuzz() {
  local seconds="${1:-60}"
  build fuzz fuzz_store
  build/fuzz/bin/fuzz_store -max_total_time="$seconds" -max_len=400 -len_control=0 -rss_limit_mb=2048 -timeout=20 \
    -print_final_stats=1 -artifact_prefix=build/fuzz/
}

case "${1:-}" in
  demo)
    prepare
    demo "${@:2}"
    ;;
  test)
    prepare
    run_tests
    ;;
  bench)
    prepare
    bench "${@:2}"
    ;;
  fuzz)
    packages+=("${fuzz_packages[@]}")
    prepare
    fuzz "${@:2}"
    ;;
  -h | --help) usage ;;
  *)
    usage >&2
    exit 2
    ;;
esac
