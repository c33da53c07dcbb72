#!/bin/sh
# Updates requirements/*.txt: one version of every package for Python 3.10 and newer, with hashes and without registry
# addresses. Run it after changing the dependencies in pyproject.toml.
set -eu
cd "$(dirname "$0")/.."

compile() {
  output="$1"; shift
  .venv/bin/python -m uv pip compile --quiet --universal --python-version 3.10 --generate-hashes \
    --no-emit-index-url --no-emit-find-links --custom-compile-command scripts/lock.sh \
    --output-file "$output" "$@"
}

compile requirements/run.txt pyproject.toml --group pyproject.toml:build "$@"
compile requirements/extras.txt pyproject.toml --extra global --extra tune --extra view --group pyproject.toml:build \
  --constraints requirements/run.txt "$@"
compile requirements/dev.txt pyproject.toml --extra global --extra tune --extra view --group pyproject.toml:build \
  --group pyproject.toml:test --group pyproject.toml:coverage \
  --group pyproject.toml:lint --constraints requirements/extras.txt "$@"
compile requirements/ros.txt pyproject.toml --extra ros --group pyproject.toml:build \
  --group pyproject.toml:ros-messages --constraints requirements/dev.txt "$@"
compile requirements/fuzz.txt --group pyproject.toml:fuzz "$@"
echo uv | compile requirements/uv.txt - "$@"
