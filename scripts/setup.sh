#!/bin/sh
# Sets up everything that `make` needs in addition to g++, make and python3 with venv.
#
#   scripts/setup.sh venv        .venv with uv inside it
#   scripts/setup.sh install F   the packages of the lock file F into .venv
#   scripts/setup.sh python      Python's headers (Python.h)
#   scripts/setup.sh gtest       GoogleTest
#   scripts/setup.sh messages    the ROS 2 messages in ros/, which are not available as wheels
#   scripts/setup.sh package     firstlap itself, editable, with its extension built in build/python
#
# Headers come from the system if installed; else they are installed by apt-get (as root, or by sudo without a
# password); else they are unpacked into build/debs, which needs no privileges.
set -eu
cd "$(dirname "$0")/.."
python=.venv/bin/python
debs=build/debs

say() { printf '%s\n' "$*" >&2; }
die() { say "error: $*"; exit 1; }

create_venv() {
  base="${PYTHON:-python3}"
  command -v "$base" >/dev/null || die "$base is missing: sudo apt-get install python3-venv"
  "$base" -c 'import sys; sys.exit(sys.version_info < (3, 10))' ||
    die "firstlap needs Python 3.10 or newer, $base is $("$base" --version 2>&1)"
  say "setting up .venv"
  rm -rf .venv
  "$base" -m venv .venv >/dev/null 2>&1 ||
    { rm -rf .venv; die "$base cannot make a virtual environment: sudo apt-get install python3-venv"; }
  "$python" -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements/uv.txt
}

uv_install() { "$python" -m uv pip install --quiet --python "$python" "$@"; }

# Installs Debian packages if permitted, else downloads them. Arguments: the packages.
install_debs() {
  command -v apt-get >/dev/null || return 1
  for as_root in "" "sudo -n"; do
    [ -n "$as_root" ] || [ "$(id -u)" = 0 ] || continue
    [ -z "$as_root" ] || command -v sudo >/dev/null || continue
    say "installing $*"
    if { $as_root apt-get -qq update && DEBIAN_FRONTEND=noninteractive $as_root apt-get -qq install -y "$@"; } \
      >/dev/null 2>&1 </dev/null; then
      return 0
    fi
  done
  say "unpacking $* into $debs"
  mkdir -p "$debs"
  (cd "$debs" && apt-get -qq download "$@" >/dev/null 2>&1) || return 1
  for deb in "$debs"/*.deb; do dpkg -x "$deb" "$debs"; rm "$deb"; done
}

python_version() { "$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])'; }

# Prints the folder of Python.h if it is not in Python's own include folder.
unpacked_python_include() {
  include="$debs/usr/include/python$(python_version)"
  [ ! -f "$include/Python.h" ] || printf '%s/%s' "$PWD" "$include"
}

system_has_python_headers() {
  "$python" -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")))'
}

python_headers() {
  system_has_python_headers && return
  [ -z "$(unpacked_python_include)" ] || return 0
  version="$(python_version)"
  install_debs "libpython$version-dev" || true
  system_has_python_headers && return
  include="$(unpacked_python_include)"
  [ -n "$include" ] || die "Python.h is missing and could not be fetched: sudo apt-get install python$version-dev"
  # Debian's pyconfig.h includes <ARCH/pythonX.Y/pyconfig.h>: one folder must serve both.
  for arch in "$debs"/usr/include/*-linux-gnu*; do
    [ ! -d "$arch" ] || cp -r "$arch" "$include/"
  done
}

gtest() {
  probe="$(mktemp -d)"
  trap 'rm -rf "$probe"' EXIT
  printf '#include <gtest/gtest.h>\n' >"$probe/probe.cpp"
  works() { "${CXX:-g++}" -std=c++20 -fsyntax-only "$@" "$probe/probe.cpp" 2>/dev/null; }
  works && return
  works -I"$debs/usr/include" && return
  install_debs libgtest-dev || true
  works || works -I"$debs/usr/include" ||
    die "GoogleTest is missing and could not be fetched: sudo apt-get install libgtest-dev"
}

package() {
  command -v "${CXX:-g++}" >/dev/null || die "${CXX:-g++} is missing: sudo apt-get install g++"
  python_headers
  say "building firstlap: a C++ core, a simulator and their Python package, in one to three minutes"
  include="$(unpacked_python_include)"
  system_has_python_headers && include=""
  if [ -n "$include" ]; then
    set -- --config-settings="cmake.define.Python_INCLUDE_DIR=$include"
  else
    set --
  fi
  alive & waits=$!
  trap 'kill "$waits" 2>/dev/null || true' EXIT
  PATH="$PWD/.venv/bin:$PATH" uv_install --no-deps --no-build-isolation --reinstall-package firstlap "$@" --editable .
  [ ! -t 2 ] || say ""
}

# Prints a dot periodically on a terminal.
alive() {
  [ -t 2 ] || return 0
  while sleep 3; do printf '.' >&2; done
}

messages() {
  python_headers
  for package in ackermann_msgs tf2_msgs; do
    say "generating $package"
    PATH="$PWD/.venv/bin:$PATH" uv_install --no-deps --no-build-isolation "./ros/$package"
  done
}

case "${1:-}" in
  venv) create_venv ;;
  install) say "installing $2"; uv_install --require-hashes -r "$2" ;;
  python) python_headers ;;
  gtest) gtest ;;
  messages) messages ;;
  package) package ;;
  *) die "usage: scripts/setup.sh venv|install FILE|python|gtest|messages|package" ;;
esac
