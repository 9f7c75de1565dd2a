#!/usr/bin/env bash
# From a checkout to a moving line: installs what is missing, builds, and runs the eight-axis example.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat <<'USAGE'
usage: ./run.sh [--no-install] [-- ARGUMENTS]
Installs missing packages, builds and runs `driveline run` on examples/line8.toml.
  --no-install   do not install missing packages
  -- ARGUMENTS   passed to `driveline run`, e.g. -- --duration 5; --config replaces the example
  --help         this text
USAGE
}

fail() {
  echo "run.sh: $*" >&2
  exit 1
}

install=yes
arguments=()
while [ $# -gt 0 ]; do
  case "$1" in
    --no-install) install=no ;;
    --help | -h) usage; exit 0 ;;
    --) shift; arguments=("$@"); break ;;
    *) echo "run.sh: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done

config=(--config "$root/examples/line8.toml")
for argument in "${arguments[@]}"; do
  case "$argument" in --config | --config=*) config=() ;; esac
done

# Minutes that the first build takes here. It takes 660 processor seconds on a processor that counts to 100,000 in 0.25 s.
minutes_to_build() {
  local begin=${EPOCHREALTIME/[.,]/} i
  for ((i = 0; i < 100000; ++i)); do :; done
  local microseconds=$((${EPOCHREALTIME/[.,]/} - begin))
  echo $(((660 * microseconds / 250000 / $(nproc) + 59) / 60))
}

build=$root/build
# Progress goes to stderr, so that `./run.sh -- --json` leaves one JSON document on stdout.
{
  if [ ! -x "$build/driveline" ]; then
    packages=
    if [ "$install" = yes ] && ! "$root/scripts/install-deps.sh" --for run --check >/dev/null 2>&1; then
      packages="a minute or two for packages, then "
    fi
    echo "run.sh: the first run builds driveline: ${packages}about $(minutes_to_build) min for compiling on $(nproc) processors"
  fi
  if [ "$install" = yes ]; then "$root/scripts/install-deps.sh" --for run; fi
  command -v cmake >/dev/null && command -v ninja >/dev/null ||
    fail "cmake or ninja is missing: run scripts/install-deps.sh --for run, or ./run.sh without --no-install"
  # Ninja itself configures again where that is necessary; a configuration that was interrupted has left no build.ninja.
  if [ ! -f "$build/build.ninja" ]; then
    echo "run.sh: configuring"
    cmake -S "$root" --preset release -DDRIVELINE_TESTS=OFF -DDRIVELINE_BENCH=OFF ||
      fail "the configuration failed, its message is above; scripts/install-deps.sh --for run installs what it needs"
  fi
  echo "run.sh: building driveline and its DDS programs"
  cmake --build "$build" --target driveline driveline-bridge driveline-dds -j "$(nproc)" ||
    fail "the build failed, its message is above; the next ./run.sh continues from there (if the disk is full: df -h '$root')"
} >&2

exec "$build/driveline" run "${config[@]}" "${arguments[@]}"
