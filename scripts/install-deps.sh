#!/usr/bin/env bash
# Installs the Debian 12 packages that building, testing and running driveline takes. Idempotent: what is there is
# left alone, and when nothing is missing neither root nor the network is touched.
set -euo pipefail

# The one list of packages: name, then what it is for.
packages() {
  sed -e 's/#.*//' -e '/^[[:space:]]*$/d' <<'TABLE'
# build
g++                   C++20 compiler
cmake                 build description
ninja-build           build tool
ccache                makes the second build cheap
clang                 second compiler; fuzz targets
libclang-rt-14-dev    sanitizer and fuzzer run-times of clang
clang-format          format check
clang-tidy            static analysis
# libraries
libeigen3-dev         linear algebra of the trajectories
libfastrtps-dev       Fast DDS, telemetry
libtinyxml2-dev       what Fast DDS reads profiles with: QoS of the telemetry
libfastcdr-dev        serialisation for Fast DDS
fastddsgen            C++ types from the IDL
default-jre-headless  runs fastddsgen
libexpected-dev       tl::expected, errors as values
libpugixml-dev        ESI files
libtomlplusplus-dev   line configurations
libcli11-dev          command line
libfmt-dev            text
libspdlog-dev         logging
nlohmann-json3-dev    machine-readable output
libmicrohttpd-dev     web page of a simulated drive
# tests and benchmarks
libgtest-dev          GoogleTest
libgmock-dev          matchers and mocks
libbenchmark-dev      micro-benchmarks
librapidcheck-dev     properties over random input
tshark                oracle for EtherCAT frames
cyclonedds-dev        oracle for the telemetry: another DDS implementation
cyclonedds-tools      its IDL compiler
curl                  asks the web page of a simulated drive
iputils-ping          asks its IP stack
rt-tests              cyclictest, the peer of the benchmark of jitter
stress-ng             the load that it is measured under
dpkg-dev              Debian packages: what they depend on
lintian               judges them
systemd               judges the unit of the service
openssl               keys and permissions of DDS Security
strace                which system calls a run makes, against those that the unit allows
procps                sysctl: this machine as the router of a service PC
python3               structure checks, checks of JSON output
doxygen               reference of the library
zsh                   its completion is tried
# running
gnuplot-nox           plots
graphviz              picture of the bus
iproute2              veth pairs: the two-process form, the network of a simulated drive
ethtool               switches its offloads off
libcap2-bin           setcap: real-time run without root
TABLE
}

usage() {
  cat <<'USAGE'
usage: scripts/install-deps.sh [--check]
Installs the Debian packages that are missing, as root or through sudo.
  --check   only report; exit status 1 when something is missing
  --help    this text
USAGE
}

fail() {
  echo "install-deps: $*" >&2
  exit 1
}

check_only=no
while [ $# -gt 0 ]; do
  case "$1" in
    --check) check_only=yes ;;
    --help | -h) usage; exit 0 ;;
    *) echo "install-deps: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  fail "this is not a Debian-like system (no apt-get); install the packages listed in scripts/install-deps.sh by hand and use --no-install"
fi

is_installed() {
  local state
  state=$(dpkg-query -W -f='${db:Status-Status}\n' "$1" 2>/dev/null) && grep -qx installed <<<"$state"
}

missing=()
while read -r name purpose; do
  if ! is_installed "$name"; then
    printf 'missing: %-21s %s\n' "$name" "$purpose"
    missing+=("$name")
  fi
done < <(packages)

if [ ${#missing[@]} -eq 0 ]; then
  echo "install-deps: all $(packages | wc -l) packages are installed"
  exit 0
fi
if [ "$check_only" = yes ]; then
  fail "${#missing[@]} packages are missing; scripts/install-deps.sh installs them"
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || fail "installing packages takes root, and there is no sudo: run this script as root, or install the packages above by hand"
  as_root=(sudo)
fi
apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q "$@"; }

echo "install-deps: installing ${#missing[@]} packages"
apt update || fail "apt-get update failed; its message is above"
apt install -y --no-install-recommends "${missing[@]}" ||
  fail "apt-get could not install the packages; the names are those of Debian 12"
echo "install-deps: done"
