#!/bin/bash
# Builds the libFuzzer targets with clang and sanitizers, and runs them one after the other.
#   tests/fuzz/run.sh [--seconds S] [--target obj|ply|stl|draco|landmarks]
# Seeds lie in tests/fuzz/corpus; what the fuzzers find grows in build/fuzz/corpus, and inputs that
# break something are left in build/fuzz/artifacts. Exit status 1 if there is one.
set -euo pipefail

seconds=20
targets=(obj ply stl draco landmarks)
while (($# > 0)); do
  case "$1" in
    --seconds) seconds="$2" ;;
    --target) targets=("$2") ;;
    *) sed -n '2,5s/^# *//p' "$0" >&2; exit 2 ;;
  esac
  shift 2
done

root="$(cd "$(dirname "$0")/../.." && pwd)"
seeds="$root/tests/fuzz"
build="${COHORT_FUZZ_BUILD:-$root/build/fuzz}"
cxx="$(command -v clang++-14 || command -v clang++)"
launcher="$(command -v ccache || true)"

cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
  -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" \
  -DCOHORT_FUZZ=ON -DCOHORT_SANITIZE=address,undefined >/dev/null
ninja -C "$build" "${targets[@]/%/_fuzz}" >"$build/build.log" || { cat "$build/build.log"; exit 2; }

# Damaged counts may ask for any amount of memory; the library must get bad_alloc, not an abort.
export ASAN_OPTIONS="allocator_may_return_null=1:${ASAN_OPTIONS:-}"
failed=0
for target in "${targets[@]}"; do
  corpus="$build/corpus/$target"
  artifacts="$build/artifacts/$target"
  mkdir -p "$corpus" "$artifacts"
  status=0
  "$build/bin/${target}_fuzz" "$corpus" "$seeds/corpus/$target" \
    -dict="$seeds/$target.dict" -artifact_prefix="$artifacts/" -max_total_time="$seconds" \
    -max_len=65536 -rss_limit_mb=2048 -timeout=20 -print_final_stats=1 \
    >"$build/$target.log" 2>&1 || status=$?
  executions="$(sed -n 's/^stat::number_of_executed_units: *//p' "$build/$target.log")"
  coverage="$(grep -o 'cov: [0-9]*' "$build/$target.log" | tail -1)"
  if ((status == 0)); then
    echo "$target: ${executions:-0} executions in $seconds s, ${coverage:-no coverage}, no finding"
  else
    echo "$target: FINDING after ${executions:-?} executions, see $build/$target.log"
    failed=1
  fi
done
exit "$failed"
