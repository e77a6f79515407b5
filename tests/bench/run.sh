#!/usr/bin/env bash
# Builds the benchmarks with all rivals that Debian has, makes their meshes, runs them and prints a
# Markdown table. Everything stays in build/bench/. What the table means: tests/bench/README.md.
#   usage: tests/bench/run.sh [--quick] [--check] [--readme] [--no-install] [FLAG...]
#     --quick       under 50 s after the build: fewer rounds and meshes, not the service
#     --check       exit status 1 if a row falls short of issues 3 and 4; names it
#     --readme      writes the table into tests/bench/README.md, and what README.md shows of it
#     --no-install  goes on with the rivals that are installed
#     FLAG          Google Benchmark's, e.g. --benchmark_filter=nearest --benchmark_out=FILE.json
set -euo pipefail
cd "$(dirname "$0")/../.."

build=build/bench
data=$build/bench-data
table=$build/table.md
readme=tests/bench/README.md
shared=../shared/data
model=$shared/models/ict_narrow.fmdl

usage() { sed -n '/^#   usage:/,/^set /{/^#/s/^#   //p}' tests/bench/run.sh; }
say() { echo "bench: $*" >&2; }

quick=0 write_readme=0 install=1
arguments=()
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) quick=1 arguments+=("$1") ;;
    --readme) write_readme=1 ;;
    --no-install) install=0 ;;
    -h | --help) usage; exit 0 ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

if [ "$install" -eq 1 ]; then
  deploy/install-dependencies.sh --bench >&2 ||
    say "warning: not all could be installed; goes on with the rivals that are here"
fi

build_programs() {
  local memory_gib jobs targets=(cohort-bench)
  # A translation unit of gRPC or Eigen takes about a gigabyte to compile.
  memory_gib=$(awk '/^MemAvailable/ { print int($2 / 1048576) }' /proc/meminfo)
  jobs=$(nproc)
  [ "$jobs" -le "$memory_gib" ] || jobs=$((memory_gib > 1 ? memory_gib : 1))
  [ "$quick" -eq 1 ] || targets+=(cohort cohort-server cohort-worker)
  cmake --preset release -B "$build" -DCOHORT_BENCH=ON -DCOHORT_TESTS=OFF
  cmake --build "$build" -j "$jobs" --target "${targets[@]}"
}

# make_set FOLDER VERTICES PEOPLE SPREAD: faces of so many people, unless they are there already.
make_set() {
  local folder=$data/$1/faces_$2
  [ ! -e "$(printf '%s/face_%04d_0.ply' "$folder" $(($3 - 1)))" ] || return 0
  say "makes $3 faces of $2 vertices"
  rm -rf "$folder.partial"
  "$build/make_faces" gen --model "$model" --out "$folder.partial" --ids "$3" --exprs 1 \
    --verts "$2" --id-sigma "$4" --seed 1 --no-truth --threads "$(nproc)" >"$data/make_faces.log"
  rm -rf "$folder"
  mv "$folder.partial" "$folder"
}

# Real people's variation where the model is at hand; else the program makes synthetic faces.
# A spread of 0.65 puts people 2 mm apart (RMS), as in performance.md section 0; 1 (the default) 3 mm.
make_data() {
  local size few=4 some=12 many=60
  mkdir -p "$data"
  [ -e "$model" ] || return 0
  [ -x "$build/make_faces" ] ||
    g++ -O2 -std=c++17 -pthread -o "$build/make_faces" "$shared/tools/make_faces.cpp"
  for size in 10000 60000; do make_set template "$size" 1 0; done  # the average person
  if [ "$quick" -eq 1 ]; then
    for size in 10000 20000 60000; do make_set . "$size" "$few" 0.65; done
  else
    make_set . 10000 "$some" 0.65
    make_set . 20000 "$many" 0.65
    make_set . 60000 "$many" 0.65
    make_set diverse 60000 "$few" 1
  fi
}

describe_machine() {
  local cpu commit
  cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)
  commit=$(git rev-parse --short HEAD 2>/dev/null || echo "no commit")
  echo "\`tests/bench/run.sh ${arguments[*]}\` on $cpu, $(nproc) CPUs, $(g++ -dumpfullversion | sed 's/^/g++ /'), $commit," \
    "load $(cut -d ' ' -f 1 /proc/loadavg), $(date -u +%Y-%m-%d)."
}

# Replaces what stands between the two marks of the README.
write_table() {
  local new=$readme.new
  {
    sed '/^<!-- table/q' "$readme"
    echo
    cat "$table"
    echo
    sed -n '/^<!-- end of table/,$p' "$readme"
  } >"$new"
  mv "$new" "$readme"
  say "wrote the table into $readme"
}

build_programs >&2
start=$SECONDS
make_data
program=()
[ ! -x "$build/bin/cohort" ] || program=("--cohort=$build/bin/cohort")
machine=$(describe_machine)
status=0
"$build/bin/cohort-bench" --data="$data" --shared="$shared" --table="$table.rows" \
  "${program[@]}" "${arguments[@]}" >"$build/table.out" || status=$?
if [ -s "$table.rows" ]; then
  { echo "$machine"; echo; cat "$table.rows"; } >"$table"
  rm "$table.rows"
  cat "$table"
  [ "$write_readme" -eq 0 ] || { write_table; python3 tests/tools/readme_figures.py; }
fi
grep '^falls short' "$build/table.out" || true
say "took $((SECONDS - start)) s after the build"
exit "$status"
