#!/bin/sh
# The arrows between the rooms: what may be included where. CMake holds them for linking, this for headers.
set -eu
cd "$(dirname "$0")/../cpp/firstlap"

status=0
forbid() { # files, pattern, why
  if grep -nE "$2" $1; then
    echo "error: $3" >&2
    status=1
  fi
}

forbid "$(ls ./*.hpp ./*.cpp)" '#include "firstlap/(sim|drivers|maps|random)/' "the core includes nothing but itself"
forbid "$(ls ./*.hpp ./*.cpp)" '#include <(fstream|iostream|chrono|random|thread|mutex|filesystem)>' \
  "the core knows no file, clock, random source or thread"
forbid "$(ls sim/*)" '#include "firstlap/(drivers|maps)/' "the simulator includes core and itself"
forbid "$(ls drivers/*)" '#include "firstlap/(sim|maps)/' "the drivers include core and themselves"
forbid "$(ls drivers/*)" '#include <(fstream|iostream|chrono|random|thread|mutex|filesystem)>' \
  "the drivers know no file, clock, random source or thread"
forbid "$(ls maps/*)" '#include "firstlap/(drivers|sim)/' "maps include core and itself"
forbid "$(ls maps/*)" '#include <(fstream|iostream|chrono|random|thread|mutex|filesystem)>' \
  "maps know no file, clock, foreign random source or thread"
exit $status
