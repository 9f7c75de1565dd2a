#!/usr/bin/env bash
# Prints our own C++ sources, one per line, relative to the project folder. Rooms may be named; default is all of them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
rooms=("$@")
if [ ${#rooms[@]} -eq 0 ]; then
  rooms=(rt canopen ecat_master trajectory esi slaves runtime bridge cli tests bench examples)
fi
find "${rooms[@]}" -type f \( -name '*.cpp' -o -name '*.hpp' \) | LC_ALL=C sort
