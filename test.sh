#!/usr/bin/env bash
# Builds everything (release) and runs the tests.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

usage() {
  cat <<'USAGE'
usage: ./test.sh [--no-install] [--label LEVEL ...]
Installs missing packages, builds and runs the tests; then compares docs/features.md and docs/msd.md with the results: a test
that is named there as a proof must have passed. Tests that this machine could not run are listed with the reason. The
tests of level ci, minutes of compiling and packing, run in .ci/run alone.
  --no-install    do not install missing packages
  --label LEVEL   only the tests of this level: unit, bus, replay, interop, fuzz, rt or structure; may be given several
                  times; builds what these need, without the comparison
  --help          this text
USAGE
}

fail() {
  echo "test.sh: $*" >&2
  exit 1
}

install=yes
levels=()
while [ $# -gt 0 ]; do
  case "$1" in
    --no-install) install=no ;;
    --label)
      case "${2-}" in
        unit | bus | replay | interop | fuzz | rt | structure) levels+=("$2") ;;
        *) echo "test.sh: --label takes the name of a level, not '${2-}'" >&2; usage >&2; exit 2 ;;
      esac
      shift ;;
    --help | -h) usage; exit 0 ;;
    *) echo "test.sh: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done

if [ ${#levels[@]} -eq 0 ]; then
  targets=(all)
  selection=(-LE '^ci$')
else
  targets=(installed examples/all bench/all)
  for level in "${levels[@]}"; do targets+=("tests/$level/all"); done
  selection=(-L "^($(IFS='|' && echo "${levels[*]}"))\$")
fi

build=$root/build
if [ "$install" = yes ]; then "$root/scripts/install-deps.sh" --for test; fi
command -v cmake >/dev/null && command -v ninja >/dev/null ||
  fail "cmake or ninja is missing: run scripts/install-deps.sh, or ./test.sh without --no-install"
echo "test.sh: configuring"
cmake -S "$root" --preset release ||
  fail "the configuration failed, its message is above; scripts/install-deps.sh installs what it needs"
echo "test.sh: building"
cmake --build "$build" --target "${targets[@]}" -j "$(nproc)" ||
  fail "the build failed, its message is above; the next ./test.sh continues from there (if the disk is full: df -h '$root')"
echo "test.sh: testing"
results=$build/test-results.xml
ctest --test-dir "$build" --output-on-failure --no-tests=error -j "$(nproc)" --output-junit "$results" "${selection[@]}"
if [ ${#levels[@]} -eq 0 ]; then
  echo "test.sh: comparing the documents with the test results"
  python3 -B "$root/tests/structure/check.py" proofs --junit "$results" --build "$build" --left-out 'install\.(consumer|packages)'
fi
