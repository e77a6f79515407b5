#!/usr/bin/env bash
# Builds one preset and runs its tests with CTest; installs first what that needs.
# The build, the log and the JUnit file stay in build/PRESET/. With CI=true the build goes on after
# an error, so that one run shows them all, and no test output is coloured.
#   usage: tests/run.sh [--preset release|debug|asan|tsan] [--target NAME]... [ctest arguments...]
#     --target NAME   builds only this target (may be repeated); the rest does not run
#   e.g.   tests/run.sh -R common/geometry        tests/run.sh --preset asan -LE e2e
set -euo pipefail
cd "$(dirname "$0")/.."

usage() { sed -n '/^#   usage:/,/^set /{/^#/s/^#   //p}' tests/run.sh; }

original_arguments=("$@")
preset=release
targets=()
while [ $# -gt 0 ]; do
  case "$1" in
    --preset | --target)
      [ $# -ge 2 ] || { usage >&2; exit 2; }
      if [ "$1" = --preset ]; then preset=$2; else targets+=("$2"); fi
      shift 2
      ;;
    -h | --help) usage; exit 0 ;;
    *) break ;;
  esac
done
case "$preset" in release | debug | asan | tsan) ;; *) usage >&2; exit 2 ;; esac

# GCC 12's ThreadSanitizer aborts at random where the kernel spreads addresses more widely than it
# knows; the tests are run already by the build, which asks each for its list.
if [ "$preset" = tsan ] && [ -z "${COHORT_FIXED_ADDRESSES:-}" ] && setarch -R true 2>/dev/null; then
  COHORT_FIXED_ADDRESSES=1 exec setarch -R "$BASH" tests/run.sh "${original_arguments[@]}"
fi

# A translation unit of gRPC or Eigen takes about a gigabyte to compile.
memory_gib=$(awk '/^MemAvailable/ { print int($2 / 1048576) }' /proc/meminfo)
jobs=$(nproc)
[ "$jobs" -le "$memory_gib" ] || jobs=$((memory_gib > 1 ? memory_gib : 1))
keep_going=1
if [ "${CI:-}" = true ]; then
  keep_going=0
  export GTEST_COLOR=no CLICOLOR=0
fi
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1:second_deadlock_stack=1

deploy/install-dependencies.sh --tests
start=$SECONDS
cmake --preset "$preset" -DCOHORT_TESTS=ON
cmake --build --preset "$preset" -j "$jobs" ${targets[0]+--target "${targets[@]}"} -- \
  -k "$keep_going"
echo "tests/run.sh: preset $preset built in $((SECONDS - start)) s"

start=$SECONDS
status=0
ctest --test-dir "build/$preset" -j2 --output-on-failure --no-tests=error \
  --output-junit tests.xml --output-log "build/$preset/tests.log" "$@" || status=$?
echo "tests/run.sh: tests of preset $preset ended with $status after $((SECONDS - start)) s"
exit "$status"
