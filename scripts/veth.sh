#!/usr/bin/env bash
# Makes and removes the pair of virtual Ethernet interfaces that joins the two processes of the two-process form:
# whatever `driveline run` sends on dl-master arrives at `driveline simulate` on dl-line, and back.
set -euo pipefail

usage() {
  cat <<'USAGE'
usage: scripts/veth.sh up|down [--netns NAME]
  up             makes the pair dl-master <-> dl-line and brings it up
  down           removes it
  --netns NAME   in a network namespace of its own, made and removed together with the pair
Needs root (CAP_NET_ADMIN). Exit status 77: this kernel or container gives no veth.
USAGE
}

[ $# -ge 1 ] || { usage >&2; exit 2; }
netns=
action=
while [ $# -gt 0 ]; do
  case "$1" in
    up | down) action=$1 ;;
    --netns)
      if [ $# -lt 2 ]; then usage >&2; exit 2; fi
      netns=$2
      shift ;;
    --help | -h) usage; exit 0 ;;
    *) echo "veth.sh: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done
[ -n "$action" ] || { usage >&2; exit 2; }

# Runs a command inside the namespace, if there is one.
inside() {
  if [ -n "$netns" ]; then ip netns exec "$netns" "$@"; else "$@"; fi
}

no_veth() {
  echo "veth.sh: no veth pair is possible here: $*" >&2
  exit 77
}

if [ "$action" = down ]; then
  if [ -n "$netns" ]; then
    ip netns del "$netns"
  else
    ip link del dl-master
  fi
  exit 0
fi

if [ -n "$netns" ]; then
  message=$(ip netns add "$netns" 2>&1) || no_veth "$message"
fi
if ! message=$(inside ip link add dl-master type veth peer name dl-line 2>&1); then
  if [ -n "$netns" ]; then ip netns del "$netns"; fi
  no_veth "$message"
fi
if [ -n "$netns" ]; then inside ip link set dev lo up; fi  # telemetry needs it
for interface in dl-master dl-line; do
  # Only EtherCAT may appear on this wire: no neighbour discovery, no ARP, nothing merged or split on the way.
  ipv6=/proc/sys/net/ipv6/conf/$interface/disable_ipv6
  inside sh -c "if [ -e $ipv6 ]; then echo 1 > $ipv6; fi"
  inside ethtool -K "$interface" rx off tx off tso off gso off gro off >/dev/null
  inside ip link set dev "$interface" arp off up
done
