#!/usr/bin/env bash
# Fuzzes the code that reads files (tests/fuzz):
#
#   ci/fuzz.sh [--assets DIR] SECONDS [TARGET...]   run the targets (default: all) for SECONDS in total
#   EMBERLINE_JOBS                                  parallel jobs (default: one per processor)
#   ci/fuzz.sh [--assets DIR] --coverage            print how much code the corpus covers so far, by folder
#
# DIR, or $EMBERLINE_ASSETS, contains seed files in addition to those that make_seeds writes. The script keeps inputs
# that reach new code in build/fuzz/corpus for the next run, and findings in build/fuzz/findings. If this run has
# findings, the exit code is 1.
set -euo pipefail
cd "$(dirname "$0")/.."

all=(gltf image draco meshopt environment frame edits display)
assets=${EMBERLINE_ASSETS:-} jobs=${EMBERLINE_JOBS:-$(nproc)}
seconds='' coverage=no targets=()
usage() {
  echo "usage: ci/fuzz.sh [--assets DIR] SECONDS|--coverage [TARGET...]; targets are ${all[*]}" >&2
  exit 2
}
while [ $# -gt 0 ]; do
  case $1 in
    --assets) [ $# -gt 1 ] || usage; assets=$2; shift ;;
    --coverage) coverage=yes seconds=0 ;;
    *) if [ -z "$seconds" ]; then seconds=$1; else targets+=("$1"); fi ;;
  esac
  shift
done
[[ $seconds =~ ^[0-9]+$ ]] || usage
[ ${#targets[@]} -gt 0 ] || targets=("${all[@]}")
for target in "${targets[@]}"; do [[ " ${all[*]} " == *" $target "* ]] || usage; done

ci/setup.sh clang-14 llvm-14 libclang-rt-14-dev zlib1g-dev dpkg-dev
out=$PWD/build/fuzz
mkdir -p "$out/corpus" "$out/logs" "$out/findings"

# Fetches the sources of decoders, which are compiled and instrumented with the targets (tests/fuzz/CMakeLists.txt).
fetch_sources() {
  local folder=$out/sources lists
  [ -d "$folder/draco" ] && [ -d "$folder/meshoptimizer" ] && return
  lists=$folder/apt
  mkdir -p "$lists/partial"
  sed -s 's/^Types: deb$/Types: deb-src/' /etc/apt/sources.list.d/debian.sources >"$folder/debian.sources"
  local apt=(apt-get -o Dir::Etc::SourceList="$folder/debian.sources" -o Dir::Etc::SourceParts=/dev/null
             -o Dir::State::Lists="$lists" -o APT::Sandbox::User=root)
  "${apt[@]}" update
  (cd "$folder" && "${apt[@]}" source --download-only draco meshoptimizer)
  for name in draco meshoptimizer; do
    rm -rf "${folder:?}/$name"
    dpkg-source -x "$folder/$name"_*.dsc "$folder/$name"
  done
}
quietly() {
  "$@" >"$out/logs/build.log" 2>&1 || { tail -n 30 "$out/logs/build.log" >&2; exit 1; }
}
quietly fetch_sources
preset=fuzz
[ $coverage = no ] || preset=fuzz-coverage
quietly cmake --preset $preset -DEMBERLINE_FUZZ_SOURCES="$out/sources"
quietly cmake --build --preset $preset
bin=$PWD/build/$preset/bin

export TMPDIR
TMPDIR=$(mktemp -d /dev/shm/fuzz-XXXXXX)
trap 'rm -rf "$TMPDIR"' EXIT
rm -rf "$out/seeds"
ASAN_OPTIONS=detect_leaks=0 "$bin/make_seeds" "$out/seeds" ${assets:+"$assets"}

if [ $coverage = yes ]; then
  profiles=() objects=()
  for target in "${targets[@]}"; do
    mkdir -p "$out/corpus/$target"
    LLVM_PROFILE_FILE=$TMPDIR/$target.profraw "$bin/fuzz_$target" -runs=0 "$out/corpus/$target" \
      "$out/seeds/$target" >"$out/logs/$target-coverage.log" 2>&1
    profiles+=("$TMPDIR/$target.profraw")
    objects+=(-object "$bin/fuzz_$target")
  done
  llvm-profdata-14 merge -o "$out/coverage.profdata" "${profiles[@]}"
  llvm-cov-14 export -summary-only -instr-profile "$out/coverage.profdata" "${objects[@]}" |
    python3 tests/fuzz/coverage_by_folder.py "$PWD" "$out/sources"
  exit
fi

# An input that exceeds these limits counts as a finding. The limits allow for AddressSanitizer, which takes about four
# fifths of the time. Leak detection is off, because OpenColorIO leaks memory.
limits=(-timeout=25 -rss_limit_mb=2000 -malloc_limit_mb=300 -max_len=20000)
export ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1
seconds=$((seconds / ${#targets[@]}))
fuzz() {
  local target=$1 end=$((SECONDS + seconds)) log status=0
  mkdir -p "$out/corpus/$target"
  while [ $SECONDS -lt $end ]; do
    log=$out/logs/$target-$(date +%Y%m%d-%H%M%S).log
    TIMEFORMAT='cpu: %U + %S s'
    { time "$bin/fuzz_$target" "${limits[@]}" -max_total_time=$((end - SECONDS)) -print_final_stats=1 \
      -artifact_prefix="$out/findings/$target-" "$out/corpus/$target" "$out/seeds/$target"; } >"$log" 2>&1 || {
      status=1
      echo "$target: finding: $(grep -m1 -E 'SUMMARY|broken promise' "$log" || tail -n 1 "$log") ($log)"
    }
    echo "$target: $(sed -n 's/^stat::number_of_executed_units: */executions: /p' "$log"), $(tail -n 1 "$log"), $(grep -oE 'cov: [0-9]+ ft: [0-9]+' "$log" | tail -n 1)"
  done
  return $status
}
status=0
for target in "${targets[@]}"; do
  while [ "$(jobs -pr | wc -l)" -ge "$jobs" ]; do wait -n || status=1; done
  fuzz "$target" &
done
while [ -n "$(jobs -p)" ]; do wait -n || status=1; done
exit $status
