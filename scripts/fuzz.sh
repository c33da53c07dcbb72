#!/bin/bash
# Fuzzes `step` (libFuzzer), the map reader and the setup reader (atheris), each for the given number of seconds.
set -euo pipefail
cd "$(dirname "$0")/.."
export PATH="$PWD/.venv/bin:$PATH"
seconds="${1:-30}"

command -v clang++-16 >/dev/null || { echo "error: clang++-16 is missing: sudo apt-get install clang-16 libclang-rt-16-dev" >&2; exit 1; }
mkdir -p build/corpus/{step,map,setup}
cmake --preset fuzz >build/fuzz.log 2>&1 || { cat build/fuzz.log; exit 1; }
cmake --build --preset fuzz

echo "== step"
build/fuzz/cpp/fuzz_step -max_total_time="$seconds" -max_len=4096 -timeout=5 -print_final_stats=1 \
  -artifact_prefix=build/corpus/ build/corpus/step 2>&1 | grep -E 'stat::|ERROR|SUMMARY|panic|DONE|abort' ; [ "${PIPESTATUS[0]}" = 0 ]

if ! python -c 'import atheris' 2>/dev/null; then
  echo "atheris has no wheel for this Python version: skipping the readers"
  exit 0
fi
cp setups/*.yaml build/corpus/setup/
for reader in map setup; do
  echo "== $reader reader"
  python "python/fuzz/fuzz_$reader.py" -max_total_time="$seconds" -timeout=20 -print_final_stats=1 \
    -artifact_prefix=build/corpus/ "build/corpus/$reader" 2>&1 | grep -E 'stat::|ERROR|SUMMARY|Exception|Error|DONE' ; [ "${PIPESTATUS[0]}" = 0 ]
done
