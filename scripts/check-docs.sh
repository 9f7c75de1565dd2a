#!/usr/bin/env bash
# Makes the reference of the library with Doxygen, into the given folder or one that is thrown away. Fails at the first
# warning: a reference that leads nowhere, a parameter or a command that does not exist, a class, function or enumeration
# in a public header without a comment, a namespace that the reference leaves out for want of one. Comparison and
# assignment speak for themselves, and so do a register, whose value has name and source, and a field or a short name of
# a type that needs no more than it says. Exit status 77: no Doxygen here.
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
awk '
  / is not documented\.$/ && (/operator(=|==|<=>)\(/ || /\((variable|typedef)\)/ || / of namespace driveline::wire::reg is /) { next }
  !/^ *$/' "$temporary/warnings" >"$temporary/complaints"
# Doxygen leaves out what is in a namespace without a comment, and says nothing.
grep -rhoE --include='*.hpp' '^(inline )?namespace [a-z0-9_:]+' ./*/include ./canopen/*/include ./ecat_master/*/include | awk '{ print $NF }' |
  sort -u | while read -r name; do
  case "$name" in *_detail) continue ;; esac
  page=${name//_/__}
  compgen -G "$DRIVELINE_DOCS/html/namespace*${page//::/_1_1}.html" >/dev/null ||
    echo "namespace $name is not documented: give it a comment, or a line in docs/namespaces.dox"
done >>"$temporary/complaints"
if [ -s "$temporary/complaints" ]; then
  cat "$temporary/complaints" >&2
  echo "check-docs: the warnings above" >&2
  exit 1
fi
echo "check-docs: $(find "$DRIVELINE_DOCS/html" -name '*.html' | wc -l) pages without a warning"
