#!/usr/bin/env bash
# Installs, on Debian 12, the packages that Cohort is built from; with --tests also what its tests
# and gates need, with --browser what the tests of report.html open it in (Chromium, 120 MB; without it
# they are skipped), with --bench what its benchmarks and their rivals need. Does nothing when
# everything is there already, so every other script calls it.
#   usage: deploy/install-dependencies.sh [--tests | --browser | --bench]
set -euo pipefail

# libgrpc++-dev alone can neither compile a .proto nor be found by CMake: the compiler, its gRPC
# plugin and libprotobuf's headers are packages of their own. libsoci-dev brings every back end's
# run-time library, but none of the headers (SQLite's, PostgreSQL's, Boost's) that its own include.
build_packages=(
  g++ cmake ninja-build ccache pkg-config
  libgrpc++-dev libprotobuf-dev protobuf-compiler protobuf-compiler-grpc libabsl-dev
  libeigen3-dev libnanoflann-dev libdraco-dev libzstd-dev
  libsqlite3-dev libpq-dev libsoci-dev
  libssl-dev libspdlog-dev libfmt-dev libcli11-dev nlohmann-json3-dev libpugixml-dev
  libcairo2-dev fonts-dejavu-core prometheus-cpp-dev
)
test_packages=(
  libgtest-dev libgmock-dev postgresql
  clang-14 clang-format-14 clang-tidy-14 libclang-rt-14-dev
  python3 python3-numpy shellcheck git ca-certificates procps iproute2
)
# The rivals in tests/bench; some 250 MB to download. small_gicp and libigl are not in Debian 12.
bench_packages=(
  libbenchmark-dev libcgal-dev libembree-dev libopen3d-dev libpcl-dev libvtk9-dev
)

usage() { sed -n 's/^#   usage: /usage: /p' "$0"; }
say() { echo "install-dependencies: $*"; }
fail() {
  say "$*" >&2
  exit 1
}

packages=("${build_packages[@]}")
# Any version of Boost's headers will do; Debian's two versions exclude each other.
[ -f /usr/include/boost/version.hpp ] || packages+=(libboost-dev)
case "${1:-}" in
  "") ;;
  --tests)
    packages+=("${test_packages[@]}")
    # buf, which lints the protos, comes from npm. A machine with another Node.js keeps it:
    # Debian's npm cannot be installed beside it.
    command -v npm >/dev/null || packages+=(nodejs npm)
    ;;
  --browser) packages+=(python3 chromium) ;;
  --bench) packages+=("${bench_packages[@]}") ;;
  -h | --help)
    usage
    exit 0
    ;;
  *)
    usage >&2
    exit 2
    ;;
esac

for tool in apt-get dpkg-query; do
  command -v "$tool" >/dev/null ||
    fail "needs Debian's $tool; on another system install what $0 names yourself"
done

is_installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

missing=()
for package in "${packages[@]}"; do
  is_installed "$package" || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
  say "all ${#packages[@]} packages are installed already"
  exit 0
fi

# shellcheck source=/dev/null
release=$(. /etc/os-release && echo "$ID ${VERSION_ID:-}")
[ "$release" = "debian 12" ] ||
  say "warning: tried on Debian 12 only, this is '$release'; package names may differ" >&2

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null ||
    fail "not root and no sudo here; run as root: apt-get install ${missing[*]}"
  say "not root: uses sudo, which may ask for your password"
  as_root=(sudo)
fi

apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -q -y -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" </dev/null
}
install_missing() { apt install --no-install-recommends "${missing[@]}"; }

say "installs ${#missing[@]} of ${#packages[@]} packages: ${missing[*]}"
start=$SECONDS
# The package lists are fetched only when there are none, or when they are too old to be served.
if ! { apt-get -s install "${missing[@]}" >/dev/null 2>&1 && install_missing; }; then
  say "fetches the package lists first"
  apt update || fail "apt-get update failed: is the network there?"
  install_missing || fail "apt-get install failed; its message is above"
fi
say "done after $((SECONDS - start)) s"
