#!/usr/bin/env bash
# Five seconds of the main job, twice: on the in-process line, and as two processes over a veth pair in a network
# namespace of its own. The figures that `driveline run --json` prints are checked against the contract.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() {
  cat <<'USAGE'
usage: scripts/smoke.sh [--build DIR]
  --build DIR   folder with the driveline program (default: build)
Exit status 0: both passed; 1: one failed; 77: the in-process line passed, and there is no veth pair here for the other.
USAGE
}

build=$root/build
while [ $# -gt 0 ]; do
  case "$1" in
    --build)
      if [ $# -lt 2 ]; then usage >&2; exit 2; fi
      build=$(cd "$2" && pwd)
      shift ;;
    --help | -h) usage; exit 0 ;;
    *) echo "smoke: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done
driveline=$build/driveline
[ -x "$driveline" ] || { echo "smoke: $driveline does not exist; build first: ./run.sh" >&2; exit 1; }

# The programs leave their plots and captures in the folder they run in; here that is a temporary one.
scratch=$(mktemp -d)
netns=driveline-smoke-$$
line_pid=
cleanup() {
  if [ -n "$line_pid" ] && kill -0 "$line_pid" 2>/dev/null; then
    kill -KILL "$line_pid"
  fi
  if [ -e "/run/netns/$netns" ]; then
    "$root/scripts/veth.sh" down --netns "$netns"
  fi
  rm -rf "$scratch"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
cd "$scratch"

echo "smoke: 5 s on the in-process line"
timeout 120 "$driveline" run --config "$root/examples/line8.toml" --duration 5 --json >in-process.json
python3 "$root/scripts/check_run_json.py" --axes 8 --duration 5 --no-lost-frames in-process.json

echo "smoke: 5 s as two processes over veth"
status=0
"$root/scripts/veth.sh" up --netns "$netns" || status=$?
if [ "$status" -eq 77 ]; then
  echo "smoke: SKIPPED the two-process form: only the in-process line has been run" >&2
  exit 77
elif [ "$status" -ne 0 ]; then
  exit "$status"
fi

# The machine may be slow for some 50 ms, in which all answers are late. This run is about the program.
sed 's/^max_lost_ms = .*/max_lost_ms = 500/' "$root/examples/line8-nic.toml" >line8-nic.toml
cp "$root/examples/line8.csv" .
grep -q '^max_lost_ms = 500$' line8-nic.toml

ip netns exec "$netns" "$driveline" simulate --config line8-nic.toml --iface dl-line >simulate.log 2>&1 &
line_pid=$!

# The line is up when its packet socket for EtherType 88A4 shows in the namespace's socket table.
deadline=$((SECONDS + 20))
until ip netns exec "$netns" grep -qi ' 88a4 ' /proc/net/packet; do
  if ! kill -0 "$line_pid" 2>/dev/null || [ "$SECONDS" -ge "$deadline" ]; then
    echo "smoke: the simulated line did not start:" >&2
    cat simulate.log >&2
    exit 1
  fi
  sleep 0.1
done

# A machine that suspends one of the two processes for longer than the line puts up with ends a run; that says something
# about the machine, so the run gets two more attempts. Anything else is a failure at once.
for attempt in 1 2 3; do
  if timeout 120 ip netns exec "$netns" "$driveline" run --config line8-nic.toml --iface dl-master \
       --duration 5 --telemetry --json >veth.json 2>master.log; then
    break
  fi
  cat master.log >&2
  if [ "$attempt" -eq 3 ] || ! grep -qE 'communication lost|the master was away for .*longer than|fault 0x8611' master.log; then
    echo "smoke: the master failed; output of the simulated line:" >&2
    cat simulate.log >&2
    exit 1
  fi
  echo "smoke: attempt $attempt was disturbed by the machine; trying again"
done
python3 "$root/scripts/check_run_json.py" --axes 8 --duration 5 veth.json

# SIGTERM takes the line down in order.
kill -TERM "$line_pid"
status=0
wait "$line_pid" || status=$?
line_pid=
if [ "$status" -ne 0 ]; then
  echo "smoke: the simulated line ended with status $status on SIGTERM; its output:" >&2
  cat simulate.log >&2
  exit 1
fi
echo "smoke: passed"
