#!/bin/bash
# Builds consumers of the C++ library: installed and found by find_package, and as part of their own build by
# FetchContent; both with the oldest supported CMake and compiler.
set -euo pipefail
cd "$(dirname "$0")/.."
root="$PWD"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
export CXX="${CXX:-g++-11}"
command -v "$CXX" >/dev/null || { echo "error: $CXX is missing: sudo apt-get install $CXX" >&2; exit 1; }
oldest=3.22.6
cmake() { "$root/.venv/bin/python" -m uv tool run --quiet --from "cmake==$oldest" cmake "$@"; }

quietly() { "$@" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }; }

build() { # source, build folder, further options
  quietly cmake -S "$1" -B "$2" -DCMAKE_BUILD_TYPE=Debug "${@:3}"
  quietly cmake --build "$2" --parallel "$(nproc)"
}

build . "$folder/library"
quietly cmake --install "$folder/library" --component cpp --prefix "$folder/prefix"
build examples/cpp_core "$folder/core" -DCMAKE_PREFIX_PATH="$folder/prefix"
"$folder/core/drive_a_corridor"
build examples/cpp_race "$folder/race"
"$folder/race/race_a_ring"
