#!/bin/bash
# Checks formatting, runs linters and type checks. Needs `make build` and `make dev`.
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH="$PWD/.venv/bin:$PATH"

step() { printf '== %s\n' "$*"; }

mapfile -t sources < <(find cpp python/bindings -name '*.hpp' -o -name '*.cpp' | sort)
for tool in clang-format-16 clang-tidy-16; do
  command -v "$tool" >/dev/null || { echo "error: $tool is missing: sudo apt-get install $tool" >&2; exit 1; }
done

step clang-format
clang-format-16 --dry-run -Werror "${sources[@]}"

step ruff
ruff check python scripts
ruff format --check --quiet python scripts

step imports
lint-imports

step mypy
mypy

step generated pages
python scripts/generate_docs.py --check

step clang-tidy
scripts/setup.sh gtest
cmake --preset tidy >build/tidy.log 2>&1 || { cat build/tidy.log; exit 1; }
find cpp/firstlap -name '*.cpp' -print0 |
  xargs -0 -n 2 -P "$(nproc)" clang-tidy-16 -p build/tidy --quiet --warnings-as-errors='*' 2>build/tidy.err ||
  { grep -v 'warnings generated' build/tidy.err >&2 || true; exit 1; }
