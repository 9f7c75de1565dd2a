#!/usr/bin/env bash
# Makes the reference of the library with Doxygen, into the given folder or one that is thrown away. Fails at the first
# warning: a reference that leads nowhere, a parameter or a command that does not exist, and in the rooms below anything
# public without a comment; comparison and assignment speak for themselves. Exit status 77: no Doxygen here.
set -euo pipefail
documented='bridge|ecat_master/port|ecat_master/snapshot|ecat_master/wire|esi|rt|trajectory'
usage="usage: scripts/check-docs.sh [FOLDER]"
case "${1-}" in
  --help | -h) echo "$usage"; exit 0 ;;
  -*) echo "$usage" >&2; exit 2 ;;
esac
folder=${1-}
[ -z "$folder" ] || { mkdir -p "$folder"; folder=$(cd "$folder" && pwd); }
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if ! command -v doxygen >/dev/null; then
  echo "check-docs: doxygen is not installed; scripts/install-deps.sh installs it" >&2
  exit 77
fi
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
export DRIVELINE_DOCS=${folder:-$temporary}
doxygen docs/Doxyfile >"$temporary/out" 2>"$temporary/warnings" || { cat "$temporary/warnings" >&2; exit 1; }
awk -v rooms="^($PWD/)?($documented)/include/" '
  / is not documented\.$/ { if ($0 ~ rooms && $0 !~ /operator(=|==|<=>)\(/) print; next }
  !/^ *$/' "$temporary/warnings" >"$temporary/complaints"
if [ -s "$temporary/complaints" ]; then
  cat "$temporary/complaints" >&2
  echo "check-docs: the warnings above" >&2
  exit 1
fi
echo "check-docs: $(find "$DRIVELINE_DOCS/html" -name '*.html' | wc -l) pages without a warning"
