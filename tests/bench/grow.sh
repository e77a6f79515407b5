#!/bin/bash
# What a job submitted again and a set that grew by five cost, in processor time of server and two
# workers, against the whole job over 200 synthetic faces: the figures of README's section on sets
# that grow. Ratios of one run on one machine.
#   tests/bench/grow.sh [VERTICES]        default 10000
# Uses the programs of COHORT_BIN, or else of build/release/bin.
set -euo pipefail
cd "$(dirname "$0")/../.."
bin="${COHORT_BIN:-$PWD/build/release/bin}"
vertices="${1:-10000}"
folder=$(mktemp -d -t cohort-grow-XXXXXX)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null || true; wait; rm -rf "$folder"' EXIT
export COHORT_SERVER="unix:$folder/socket"

"$bin/cohort" demo --out "$folder/faces" --people 41 --captures 5 --vertices "$vertices" >/dev/null
"$bin/cohort-server" --data "$folder/data" --listen "$COHORT_SERVER" --log-level warn >"$folder/log" 2>&1 &
pids+=($!)
for _ in 1 2; do
  "$bin/cohort-worker" --server "$COHORT_SERVER" --threads 1 --store "$folder/data/blobs" \
    --log-level warn >>"$folder/log" 2>&1 &
  pids+=($!)
done
until "$bin/cohort" jobs >/dev/null 2>&1; do sleep 0.1; done
mapfile -t faces < <(printf '%s\n' "$folder"/faces/*.ply | sort)

# Processor time of all processes, in hundredths of a second.
used() {
  local total=0 stat
  for pid in "${pids[@]}"; do
    read -ra stat <"/proc/$pid/stat"
    total=$((total + stat[13] + stat[14]))
  done
  echo "$total"
}
# Runs a job to its end; sets `cost` and `job`.
run_job() {
  local before
  before=$(used)
  job=$("$bin/cohort" submit --set faces "$@")
  "$bin/cohort" watch "$job" >/dev/null 2>&1
  cost=$(($(used) - before))
}

"$bin/cohort" add "${faces[@]:0:200}" --set faces >/dev/null
run_job
first=$job whole=$cost
run_job
again=$cost
"$bin/cohort" add "${faces[@]:200:5}" --set faces >/dev/null
run_job --reference "$first"
awk -v whole="$whole" -v again="$again" -v grown="$cost" 'BEGIN {
  printf "grow: 200 faces %.1f s of processor time; again %.2f s (%.1f %%); five more %.2f s (%.1f %%)\n",
    whole / 100, again / 100, 100 * again / whole, grown / 100, 100 * grown / whole }'
