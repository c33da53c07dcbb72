#!/bin/sh
# Tunes for arena and for every map in a folder of folders, one JSON file each; existing results are kept, and
# interrupted studies are resumed. Then: scripts/tuning_results_page.py OUT/*.json >docs/tuning_results.md
#
#   scripts/tune_maps.sh MAPS OUT [options of firstlap tune, such as --budget 3m]
set -eu
[ $# -ge 2 ] || { echo "usage: scripts/tune_maps.sh MAPS OUT [option...]" >&2; exit 2; }
maps=$1 out=$2
shift 2
firstlap="$(dirname "$0")/../.venv/bin/firstlap"
mkdir -p "$out"

tune() {
  name=$1
  shift
  [ ! -s "$out/$name.json" ] || return 0
  "$firstlap" tune "$@" --name "$name" --study "$out/studies.db" --out "$out/$name" --json >"$out/$name.part"
  mv "$out/$name.part" "$out/$name.json"
}

# Setups tuned on arena are not used as a start; `brisk` is newer than the page.
tune arena arena --starts sure,race "$@"
for map in "$maps"/*/*.yaml; do
  tune "$(basename "$map" .yaml)" "$map" --starts sure,race,local_arena "$@"
done
