#!/usr/bin/env bash
# From a checkout to a moving line: installs what is missing, builds, and runs the eight-axis example.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat <<'USAGE'
usage: ./run.sh [--no-install] [-- ARGUMENTS]
Installs missing packages, builds and runs `driveline run` on examples/line8.toml.
  --no-install   do not look for missing packages
  -- ARGUMENTS   go to `driveline run`, e.g. -- --duration 5; a --config among them replaces the example
  --help         this text
USAGE
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

# Progress goes to stderr, so that `./run.sh -- --json` leaves one JSON document on stdout.
{
  if [ "$install" = yes ]; then "$root/scripts/install-deps.sh"; fi
  echo "run.sh: configuring"
  cmake -S "$root" --preset release
  echo "run.sh: building driveline and what it has for DDS"
  cmake --build "$root/build" --target driveline driveline-bridge driveline-dds -j "$(nproc)"
} >&2

exec "$root/build/driveline" run "${config[@]}" "${arguments[@]}"
