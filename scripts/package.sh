#!/usr/bin/env bash
# Builds the Debian packages: driveline, driveline-bridge and libdriveline-dev.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
output=$root/build/packages

usage() {
  cat <<'USAGE'
usage: scripts/package.sh [--output FOLDER]
Builds (release) and puts the Debian packages into FOLDER (default: build/packages).
USAGE
}

while [ $# -gt 0 ]; do
  case "$1" in
    --output)
      if [ $# -lt 2 ]; then echo "package.sh: --output takes a folder" >&2; usage >&2; exit 2; fi
      output=$(realpath -m "$2")
      shift ;;
    --help | -h) usage; exit 0 ;;
    *) echo "package.sh: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done

build=$root/build
echo "package.sh: configuring"
if [ ! -f "$build/build.ninja" ]; then
  cmake -S "$root" --preset release -DDRIVELINE_TESTS=OFF -DDRIVELINE_BENCH=OFF
fi
echo "package.sh: building the programs"
cmake --build "$build" --target installed -j "$(nproc)"
echo "package.sh: packing"
mkdir -p "$output"
rm -f "$output"/*.deb
(cd "$build" && cpack -G DEB -B "$output" >"$output/cpack.log" 2>&1) || { cat "$output/cpack.log" >&2; exit 1; }
rm -rf "$output/_CPack_Packages" "$output/cpack.log"
ls "$output"/*.deb
