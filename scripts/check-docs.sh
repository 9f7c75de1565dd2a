#!/usr/bin/env bash
# Makes the reference of the library with Doxygen, into the given folder or one that is thrown away. Fails at the first
# warning: a reference that leads nowhere, a parameter or a command that does not exist. What has no comment speaks for
# itself by its name, as far as Doxygen is asked; reviews decide that. Exit status 77: no Doxygen here.
set -euo pipefail
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
if grep -vE ': warning: (Member|Compound) .* is not documented\.$|^ *$' "$temporary/warnings" >&2; then
  echo "check-docs: the warnings above" >&2
  exit 1
fi
echo "check-docs: $(find "$DRIVELINE_DOCS/html" -name '*.html' | wc -l) pages without a warning"
