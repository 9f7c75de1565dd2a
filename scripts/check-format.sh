#!/usr/bin/env bash
# Fails when a source is not formatted as .clang-format says; --fix formats instead.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
case "${1-}" in
  "") mode=(--dry-run -Werror) ;;
  --fix) mode=(-i) ;;
  --help | -h) echo "usage: scripts/check-format.sh [--fix]"; exit 0 ;;
  *) echo "usage: scripts/check-format.sh [--fix]" >&2; exit 2 ;;
esac
sources=$(scripts/sources.sh)
xargs -d '\n' clang-format "${mode[@]}" <<<"$sources"
echo "check-format: $(wc -l <<<"$sources") files are formatted"
