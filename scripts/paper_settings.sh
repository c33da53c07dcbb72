#!/usr/bin/env bash
# Drive the paper's settings on each track, also with the published parameters alone.
#
# Usage: scripts/paper_settings.sh OUT TRACK...   (writes OUT/NAME.json and OUT/NAME-published.json)
set -euo pipefail
cd "$(dirname "$0")/.."

out=$1
shift
mkdir -p "$out"
for track in "$@"; do
  name=$(basename "${track%.yaml}")
  .venv/bin/firstlap tune "$track" --paper --json --out "$out/$name" >"$out/$name.json"
  .venv/bin/firstlap tune "$track" --paper --published-only --json --out "$out/$name" >"$out/$name-published.json"
done
