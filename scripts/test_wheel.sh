#!/bin/bash
# Builds a wheel and races with it outside of the checkout: it must include setups and tracks.
set -euo pipefail
cd "$(dirname "$0")/.."
root="$PWD"
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
export PATH="$root/.venv/bin:$PATH"
python -m uv build --quiet --wheel --no-build-isolation --config-setting=build-dir="$folder/build" --out-dir "$folder"
python -m venv --without-pip "$folder/venv"
python -m uv pip install --quiet --python "$folder/venv/bin/python" --require-hashes -r requirements/run.txt
python -m uv pip install --quiet --python "$folder/venv/bin/python" --no-deps "$folder"/*.whl
cd "$folder"
venv/bin/firstlap race arena --setup base --laps 1
venv/bin/firstlap tracks >/dev/null
