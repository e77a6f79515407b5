#!/usr/bin/env bash
# From a fresh clone on Debian 12 to a compared cohort: installs what is needed, builds the three
# programs, makes a synthetic cohort with known truth, compares all its faces, says what to look at.
# May be run again: what is done already is not done twice, only the comparison is.
# Leaves FOLDER/scans and FOLDER/results; FOLDER is ./quickstart when not given.
#   usage: deploy/quickstart.sh [FOLDER]
set -euo pipefail
here=$(pwd)
cd "$(dirname "$0")/.."
repository=$(pwd)

case "${1:-}" in
  -h | --help)
    sed -n 's/^#   usage: /usage: /p' deploy/quickstart.sh
    exit 0
    ;;
  -*)
    sed -n 's/^#   usage: /usage: /p' deploy/quickstart.sh >&2
    exit 2
    ;;
  "") folder=$here/quickstart ;;
  /*) folder=$1 ;;
  *) folder=$here/$1 ;;
esac
scans=$folder/scans
results=$folder/results
cohort=$repository/build/release/bin/cohort

step_name="start"
step_number=0
begin=$SECONDS
step() {
  step_name=$1
  step_number=$((step_number + 1))
  printf '\n==> %d/5 %s (at %d s)\n' "$step_number" "$step_name" $((SECONDS - begin))
}
report_failure() {
  local status=$?
  [ "$status" -eq 0 ] && return
  printf '\nquickstart: FAILED after %d s in step %d, "%s" (exit status %d).\n' \
    $((SECONDS - begin)) "$step_number" "$step_name" "$status" >&2
  echo "quickstart: the reason is printed above; correct it and start the script again." >&2
}
trap report_failure EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

step "Install the Debian packages"
deploy/install-dependencies.sh

step "Configure build/release"
cmake --preset release -DCOHORT_TESTS=OFF

step "Build cohort, cohort-server and cohort-worker (some minutes the first time)"
# A translation unit of gRPC or Eigen takes about a gigabyte to compile.
memory_gib=$(awk '/^MemAvailable/ { print int($2 / 1048576) }' /proc/meminfo)
jobs=$(nproc)
[ "$jobs" -le "$memory_gib" ] || jobs=$((memory_gib > 1 ? memory_gib : 1))
cmake --build --preset release -j "$jobs" --target cohort cohort-server cohort-worker

step "Make a synthetic cohort in $scans"
if [ -s "$scans/labels.csv" ]; then
  echo "is there already; delete the folder to make it anew"
else
  mkdir -p "$folder"
  "$cohort" demo --out "$scans"
fi

step "Compare every face with every other"
compare_start=$SECONDS
"$cohort" run "$scans" --labels "$scans/labels.csv" --out "$results" --workers 2
compare_seconds=$((SECONDS - compare_start))

first=$results
for name in report.html heatmap.png matrix.csv; do
  [ ! -e "$results/$name" ] || { first=$results/$name; break; }
done
cat <<TXT

Done in $((SECONDS - begin)) s, of which the comparison took $compare_seconds s.
  results:     $results
  open first:  $first
  your scans:  $cohort run YOUR_FOLDER --out RESULTS_FOLDER
TXT
