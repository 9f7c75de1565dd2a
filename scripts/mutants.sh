#!/usr/bin/env bash
# Breaks the code on purpose, one line at a time, and runs the tests that must notice: mutants.py does the work.
set -euo pipefail
exec python3 -B "$(dirname "${BASH_SOURCE[0]}")/mutants.py" "$@"
