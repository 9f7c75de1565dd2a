#!/usr/bin/env bash
# Installs the Debian 12 packages that running, testing or checking driveline takes. Idempotent: installed packages are
# left alone, and when nothing is missing neither root nor the network is used.
set -euo pipefail

# The one list of packages: the group that needs it first, its name, and its purpose. Each group includes those before it.
packages() {
  sed -e 's/#.*//' -e '/^[[:space:]]*$/d' <<'TABLE'
# run.sh: build driveline and run a line
run   g++                   C++20 compiler
run   cmake                 build description
run   ninja-build           build tool
run   ccache                makes the second build cheap
run   libeigen3-dev         linear algebra of the trajectories
run   libfastrtps-dev       Fast DDS, telemetry
run   libtinyxml2-dev       reads the XML profiles of Fast DDS: QoS of the telemetry
run   libfastcdr-dev        serialisation for Fast DDS
run   fastddsgen            C++ types from the IDL
run   default-jre-headless  runs fastddsgen
run   libexpected-dev       tl::expected, errors as values
run   libpugixml-dev        ESI files
run   libtomlplusplus-dev   line configurations
run   libcli11-dev          command line
run   libfmt-dev            text
run   nlohmann-json3-dev    machine-readable output
run   libseccomp-dev        restricts the system calls of the telemetry process
run   libmicrohttpd-dev     web page of a simulated drive
run   python3-minimal       table of the DDS topics from the IDL
run   gnuplot-nox           plots
run   iproute2              veth pairs: the two-process form, the network of a simulated drive
run   ethtool               switches their offloads off
run   libcap2-bin           setcap: real-time run without root
# test.sh: all tests and benchmarks
test  python3               tests of the program, structure checks
test  python3-can           oracle for the simulated CAN bus
test  libgtest-dev          GoogleTest
test  libgmock-dev          matchers and mocks
test  libbenchmark-dev      micro-benchmarks
test  librapidcheck-dev     properties over random input
test  tshark                oracle for EtherCAT frames
test  cyclonedds-dev        oracle for the telemetry: another DDS implementation
test  cyclonedds-tools      IDL compiler of Cyclone DDS
test  can-utils             oracle for the logs of a CAN bus (log2asc)
test  nodejs                a foreign CANopen master, and a reader of recordings
test  npm                   gets their modules
test  curl                  requests the web page of a simulated drive
test  iputils-ping          pings the IP stack of a simulated drive
test  systemd               checks the unit of the service
test  openssl               keys and permissions of DDS Security
test  strace                system calls of a run, compared with those that the unit allows
test  procps                sysctl: this machine as the router of a service PC
test  zsh                   runs its completion
test  graphviz              draws the graph of the bus
# .ci/run: everything that a change must pass, and the measured benchmarks
ci    clang                 second compiler; fuzz targets
ci    libclang-rt-14-dev    sanitizer and fuzzer run-times of clang
ci    clang-format          format check
ci    clang-tidy            static analysis
ci    dpkg-dev              Debian packages: their dependencies
ci    lintian               checks the Debian packages
ci    doxygen               reference of the library
ci    rt-tests              cyclictest, the peer of the jitter benchmark
ci    stress-ng             load of the jitter benchmark
ci    valgrind              counts the instructions of the hot paths
TABLE
}

usage() {
  cat <<'USAGE'
usage: scripts/install-deps.sh [--for run|test|ci] [--check]
Installs the Debian packages that are missing, as root or through sudo.
  --for GROUP  run:  build and run a line, for ./run.sh
               test: the same, and all tests, for ./test.sh (default)
               ci:   the same, and static analysis, sanitizers, packages, for .ci/run
  --check      only report; exit status 1 when something is missing
  --help       this text
USAGE
}

fail() {
  echo "install-deps: $*" >&2
  exit 1
}

check_only=no
group=test
while [ $# -gt 0 ]; do
  case "$1" in
    --check) check_only=yes ;;
    --for)
      case "${2-}" in
        run | test | ci) group=$2 ;;
        *) echo "install-deps: --for takes run, test or ci, not '${2-}'" >&2; usage >&2; exit 2 ;;
      esac
      shift ;;
    --help | -h) usage; exit 0 ;;
    *) echo "install-deps: unknown argument '$1'" >&2; usage >&2; exit 2 ;;
  esac
  shift
done

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  fail "this is not a Debian-like system (no apt-get); install the packages listed in scripts/install-deps.sh by hand and use --no-install"
fi

case "$group" in
  run) groups="run" ;;
  test) groups="run test" ;;
  ci) groups="run test ci" ;;
esac

declare -A purposes=()
names=()
while read -r of name purpose; do
  if [[ " $groups " == *" $of "* ]]; then
    names+=("$name")
    purposes[$name]=$purpose
  fi
done < <(packages)

# Exit status 1 of dpkg-query only means that it does not know some of the names.
declare -A installed=()
while read -r name state; do
  if [ "$state" = installed ]; then installed[$name]=yes; fi
done < <(dpkg-query -W -f='${Package} ${db:Status-Status}\n' "${names[@]}" 2>/dev/null || true)

# The packages of nodejs that are not Debian's have npm in them, and the package npm is in conflict with them.
if command -v npm >/dev/null; then installed[npm]=yes; fi

missing=()
for name in "${names[@]}"; do
  if [ -z "${installed[$name]-}" ]; then
    printf 'missing: %-21s %s\n' "$name" "${purposes[$name]}"
    missing+=("$name")
  fi
done

if [ ${#missing[@]} -eq 0 ]; then
  echo "install-deps: all ${#names[@]} packages are installed"
  exit 0
fi
if [ "$check_only" = yes ]; then
  fail "${#missing[@]} packages are missing; scripts/install-deps.sh --for $group installs them"
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || fail "installing packages takes root, and there is no sudo: run this script as root, or install the packages above by hand and use --no-install"
  as_root=(sudo)
fi
# An installation that was interrupted, as by a full disk, goes on where it stopped.
apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o Acquire::Retries=2 "$@"; }
remedy="try again when the network is available; packages installed so far remain. Or install the packages above by hand and use --no-install"

echo "install-deps: installing ${#missing[@]} packages and their dependencies"
apt update || fail "apt-get update failed, its message is above; $remedy"
if [ -n "$("${as_root[@]}" dpkg --audit 2>/dev/null)" ]; then
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive dpkg --configure -a || fail "an earlier installation is incomplete, and dpkg --configure -a cannot complete it; its message is above"
fi
apt install -y --no-install-recommends "${missing[@]}" ||
  fail "apt-get could not install the packages, its message is above (the names are those of Debian 12; if the disk is full: df -h /); $remedy"
echo "install-deps: done"
