#!/usr/bin/env bash
# Runs a campaign of random sequences in as many processes as there are processors, each with its share of the seeds.
# Fails with what the first of them that fails has said.
set -euo pipefail

usage="usage: scripts/campaign.sh RUNS FIRST_SEED PROGRAM FILTER"
case "${1-}" in
  --help | -h) echo "$usage"; exit 0 ;;
esac
if [ $# -ne 4 ]; then
  echo "$usage" >&2
  exit 2
fi
runs=$1 seed=$2 program=$3 filter=$4
for number in "$runs" "$seed"; do
  case "$number" in
    '' | *[!0-9]* | 0*) echo "scripts/campaign.sh: '$number' is not a positive number" >&2; exit 2 ;;
  esac
done

processes=$(nproc)
[ "$processes" -le "$runs" ] || processes=$runs
said=$(mktemp -d)
children=()
end() {
  [ ${#children[@]} -eq 0 ] || kill "${children[@]}" 2>/dev/null || true
  rm -rf "$said"
}
trap end EXIT

for ((i = 0; i < processes; ++i)); do
  share=$((runs / processes + (i < runs % processes)))
  DRIVELINE_CAMPAIGN_RUNS=$share DRIVELINE_CAMPAIGN_SEED=$seed \
    "$program" --gtest_brief=1 --gtest_filter="$filter" >"$said/$i" &
  children+=($!)
  seed=$((seed + share))
done
failed=
for ((i = 0; i < processes && ${#failed} == 0; ++i)); do
  wait "${children[i]}" || failed=$i
done
if [ -n "$failed" ]; then
  cat "$said/$failed"
  exit 1
fi
children=()
tail -qn 1 "$said"/*
