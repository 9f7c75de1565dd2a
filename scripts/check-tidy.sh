#!/usr/bin/env bash
# Runs clang-tidy over our sources as the compile database of a build describes them. Any finding is an error.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

usage() {
  cat <<'USAGE'
usage: scripts/check-tidy.sh [--build DIR] [ROOM|FILE...]
  --build DIR   folder with compile_commands.json (default: build)
  ROOM|FILE...  only these (default: every .cpp that the build compiles, but the tests)
USAGE
}

build=build
selection=()
while [ $# -gt 0 ]; do
  case "$1" in
    --build)
      if [ $# -lt 2 ]; then usage >&2; exit 2; fi
      build=$2
      shift ;;
    --help | -h) usage; exit 0 ;;
    -*) echo "check-tidy: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
    *) selection+=("$1") ;;
  esac
  shift
done
if [ ${#selection[@]} -eq 0 ]; then
  selection=(rt ecat_master trajectory esi slaves runtime bridge cli bench examples)
fi
database=$build/compile_commands.json
if [ ! -f "$database" ]; then
  echo "check-tidy: $database does not exist; configure first: cmake --preset release" >&2
  exit 1
fi

# What the build compiles is what can be analysed; generated files live in the build folder and are not ours.
compiled=$(python3 -c '
import json, os, sys
for entry in json.load(open(sys.argv[1])):
    print(os.path.relpath(os.path.join(entry["directory"], entry["file"])))' "$database" | LC_ALL=C sort -u)
ours=$(scripts/sources.sh "${selection[@]}")
files=$(LC_ALL=C comm -12 <(printf '%s\n' "$compiled") <(printf '%s\n' "$ours"))
if [ -z "$files" ]; then
  echo "check-tidy: $database compiles none of the selected sources" >&2
  exit 1
fi

echo "check-tidy: $(wc -l <<<"$files") files"
xargs -d '\n' -n 1 -P "$(nproc)" clang-tidy -p "$build" --quiet <<<"$files"
echo "check-tidy: clean"
