#!/bin/bash
# Breaks a real server, its workers, its client and their network at random, and compares every
# byte of every result with an undisturbed run. Ends in one line that says what was broken.
#   tests/chaos/run.sh [--seconds S] [--seed N] [--runs R] [--meshes M] [--vertices V]
# Uses the programs of COHORT_BIN, or else of build/release/bin. Nightly: --runs 30.
set -euo pipefail
cd "$(dirname "$0")/../.."
export COHORT_BIN="${COHORT_BIN:-$PWD/build/release/bin}"
exec python3 tests/chaos/chaos.py "$@"
