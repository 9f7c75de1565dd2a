#!/usr/bin/env bash
# Builds everything (release) and runs the tests.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat <<'USAGE'
usage: ./test.sh [--no-install] [--label LABEL]
Installs missing packages, builds and runs the tests; then compares docs/features.md and docs/msd.md with what has run: a test
that is named there for a proof must have passed. What this machine could not run, and why, is listed.
  --no-install    do not look for missing packages
  --label LABEL   only the tests of one level: unit, bus, replay, interop, fuzz or rt; without the comparison
  --help          this text
USAGE
}

install=yes
selection=()
while [ $# -gt 0 ]; do
  case "$1" in
    --no-install) install=no ;;
    --label)
      if [ $# -lt 2 ]; then echo "test.sh: --label takes the name of a level" >&2; usage >&2; exit 2; fi
      selection=(-L "^$2\$")
      shift ;;
    --help | -h) usage; exit 0 ;;
    *) echo "test.sh: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done

if [ "$install" = yes ]; then "$root/scripts/install-deps.sh"; fi
echo "test.sh: configuring"
cmake -S "$root" --preset release
echo "test.sh: building"
cmake --build "$root/build" -j "$(nproc)"
echo "test.sh: testing"
results=$root/build/test-results.xml
ctest --test-dir "$root/build" --output-on-failure --no-tests=error -j "$(nproc)" --output-junit "$results" "${selection[@]}"
if [ "${#selection[@]}" -eq 0 ]; then
  echo "test.sh: comparing the documents with what has run"
  python3 -B "$root/tests/structure/check.py" proofs --junit "$results" --build "$root/build"
fi
