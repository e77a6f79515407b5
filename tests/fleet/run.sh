#!/bin/bash
# Simulated workers against a real server process with a real catalog; ends in one line of figures.
#   tests/fleet/run.sh [--workers W] [--tasks T] [--check] [options of cohort-fleet]
#     --check  fails below 500 completions a second, above 250 ms (p99 of Synchronize) or 1 GB
# Uses the programs of COHORT_BIN, or else of build/release/bin.
# Nightly: --workers 2000 --tasks 1000000 --task-seconds 3 --check
set -euo pipefail
cd "$(dirname "$0")/../.."
bin="${COHORT_BIN:-$PWD/build/release/bin}"
arguments=()
for argument in "$@"; do
  if [ "$argument" = --check ]; then
    arguments+=(--least-rate 500 --most-sync-ms 250 --most-server-mb 1024)
  else
    arguments+=("$argument")
  fi
done
folder=$(mktemp -d -t cohort-fleet-XXXXXX)
trap 'rm -rf "$folder"' EXIT
"$bin/cohort-fleet" --folder "$folder" "${arguments[@]}"
