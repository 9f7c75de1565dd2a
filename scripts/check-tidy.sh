#!/usr/bin/env bash
# Runs clang-tidy over our sources, tests included. Any finding is an error.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() {
  cat <<'USAGE'
usage: scripts/check-tidy.sh [--all | FOLDER|FILE...]
  (no argument)   files that differ from the commit in .ci/tidy-base; none, with a message, if git does not know that
                  commit: the whole tree takes most of an hour
  --all           all compiled files
  FOLDER|FILE...  only these
Uses its own build folder, build-tidy, and compiles there only what the generated sources need.
USAGE
}

selection=(--since "$(cat .ci/tidy-base)")
case "${1-}" in
  "") ;;
  --all) selection=(--all) ;;
  --help | -h) usage; exit 0 ;;
  -*) echo "check-tidy: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  *) selection=("$@") ;;
esac
if ! command -v clang-tidy >/dev/null; then
  echo "check-tidy: clang-tidy is not installed; scripts/install-deps.sh installs it" >&2
  exit 1
fi

# Every file by itself: a group of them would be looked at as one, and whole.
cmake --preset release -B build-tidy -DDRIVELINE_UNITY=OFF >/dev/null
cmake --build build-tidy --target generated_sources >/dev/null

status=0
files=$(scripts/tidy_files.py --build build-tidy "${selection[@]}") || status=$?
if [ "$status" -eq 3 ]; then
  echo "check-tidy: no file is checked; use --all to check all files"
  exit 0
elif [ "$status" -ne 0 ]; then
  exit "$status"
fi
if [ -z "$files" ]; then
  echo "check-tidy: nothing has changed"
  exit 0
fi
echo "check-tidy: $(wc -l <<<"$files") files"
xargs -d '\n' -n 1 -P "$(nproc)" clang-tidy -p build-tidy --quiet <<<"$files"
echo "check-tidy: clean"
