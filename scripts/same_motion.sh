#!/usr/bin/env bash
# Compares the motion of two commits bit for bit: the JSON documents and CSV files of lines on virtual time, and the
# demands of all drives in random campaigns. For changes that must move nothing differently.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() {
  cat <<'USAGE'
usage: scripts/same_motion.sh [--seeds N] [--keep DIR] [--build DIR] BASE
Builds the commit BASE in a worktree of its own and compares it with this checkout.
  --seeds N    sequences of each campaign (default: 1000)
  --keep DIR   folder for worktree and results, which is kept and used again (default: temporary)
  --build DIR  build of this checkout (default: build); what is missing in it is built
Exit status 0: no difference; 1: a difference, which is named; 2: wrong arguments, or BASE cannot be compared.
USAGE
}

fail() { # text [status]
  echo "same_motion: $1" >&2
  exit "${2:-1}"
}

seeds=1000 keep='' build=$root/build base=''
while [ $# -gt 0 ]; do
  case "$1" in
    --seeds | --keep | --build)
      if [ $# -lt 2 ]; then usage >&2; exit 2; fi
      case "$1" in
        --seeds) seeds=$2 ;;
        --keep) mkdir -p "$2" && keep=$(cd "$2" && pwd) ;;
        --build) build=$(cd "$2" && pwd) ;;
      esac
      shift ;;
    --help | -h) usage; exit 0 ;;
    -*) echo "same_motion: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
    *) [ -z "$base" ] || { usage >&2; exit 2; }; base=$1 ;;
  esac
  shift
done
[ -n "$base" ] || { usage >&2; exit 2; }
[[ $seeds =~ ^[1-9][0-9]*$ ]] || fail "--seeds '$seeds' is not a positive number" 2
commit=$(git -C "$root" rev-parse --verify --quiet "$base^{commit}") || fail "'$base' is not a commit" 2

work=${keep:-$(mktemp -d)}
old=$work/base
cleanup() {
  [ -n "$keep" ] || { git -C "$root" worktree remove --force "$old"; rm -rf "$work"; }
}
trap cleanup EXIT
if [ -e "$old/.git" ]; then
  git -C "$old" checkout -q --detach "$commit"
else
  git -C "$root" worktree add -q --detach "$old" "$commit"
fi
[ -e "$old/tests/support/motion_trace.hpp" ] || fail "the tests of $base do not trace motions (tests/support/motion_trace.hpp)" 2

# The single axes were part of the master's tests once.
axes_test() { # checkout
  if [ -e "$1/tests/unit/motion/CMakeLists.txt" ]; then echo motion/motion_unit_test; else echo ecat_master/ecat_master_unit_test; fi
}
build_all() { # checkout build
  [ -e "$2/build.ninja" ] || cmake -S "$1" -B "$2" --preset release >"$work/configure.log" ||
    fail "the configuration of $1 failed: $work/configure.log"
  cmake --build "$2" -j "$(nproc)" --target driveline bus_test bus_axis_test bus_demand_test bus_groups_test \
    "$(basename "$(axes_test "$1")")" >"$work/build.log" || fail "the build of $1 failed: $work/build.log"
}
echo "same_motion: building $base and this checkout"
build_all "$old" "$old/build"
build_all "$root" "$build"

# Results of a build, for comparison with those of the other: one folder for each line, one file for each campaign.
lines() { # checkout build results
  local file name mode
  for file in "$root"/examples/*.toml; do
    name=$(basename "$file" .toml)
    [ -e "$old/examples/$name.toml" ] || continue  # an example that BASE does not have
    for mode in '' csp csv cst script; do
      local arguments=(--config "$file" --virtual --duration 2 --no-plots --no-telemetry --json)
      case "$mode" in
        '') ;;
        script) [ -e "${file%.toml}.txt" ] || continue
                arguments+=(--script "${file%.toml}.txt") ;;
        *) arguments+=(--mode "$mode") ;;
      esac
      local results=$3/lines/$name${mode:+-$mode}
      mkdir -p "$results"
      (cd "$results" && "$2/driveline" run "${arguments[@]}" >run.json 2>run.txt; echo "$?" >status) || true
      # A description that the program refuses moves nothing.
      if grep -q '^2$' "$results/status"; then rm -r "$results"; fi
    done
  done
}
campaign() { # results program runs filter
  DRIVELINE_MOTION_TRACE=$1/$(basename "$2").part "$root/scripts/campaign.sh" "$3" 1 "$2" "$4" >>"$1/campaigns.txt"
  LC_ALL=C sort "$1/$(basename "$2").part" >>"$1/$(basename "$2").trace"
  rm "$1/$(basename "$2").part"
}
results_of() { # checkout build results
  rm -rf "$3" && mkdir -p "$3"
  lines "$@"
  campaign "$3" "$2/tests/unit/$(axes_test "$1")" "$seeds" 'SingleAxesCampaign.*'
  mv "$3/$(basename "$(axes_test "$1")").trace" "$3/single_axes.trace"
  campaign "$3" "$2/tests/bus/bus_demand_test" "$seeds" 'DemandCampaign.*'
  campaign "$3" "$2/tests/bus/bus_axis_test" "$seeds" 'ModeChangeCampaign.*'
  campaign "$3" "$2/tests/bus/bus_groups_test" "$seeds" 'GroupCampaign.*'
  campaign "$3" "$2/tests/bus/bus_test" "$seeds" 'RecoveryCampaign.*'
  rm "$3/campaigns.txt"
}
for side in old new; do
  echo "same_motion: lines and $seeds sequences of each campaign, $side"
  case "$side" in
    old) results_of "$old" "$old/build" "$work/old" ;;
    new) results_of "$root" "$build" "$work/new" ;;
  esac
done

if ! diff -rq "$work/old" "$work/new" >"$work/differences.txt"; then
  head -20 "$work/differences.txt" >&2
  fail "$(wc -l <"$work/differences.txt") results differ from those of $base"
fi
echo "same_motion: the same as $base: $(find "$work/new/lines" -name run.json | wc -l) lines with" \
  "$(find "$work/new/lines" -name '*.csv' | wc -l) CSV files, $(cat "$work"/new/*.trace | wc -l) traces of" \
  "$(awk '{sum += $2} END {printf "%.0f", sum}' "$work"/new/*.trace) values"
