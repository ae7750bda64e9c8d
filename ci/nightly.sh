#!/usr/bin/env bash
# What takes too long for ci/test.sh, which has a short version of each: runs all of it, says what failed, and how to
# repeat it.
#   ci/nightly.sh [STEP...]   these steps alone: tests long numerics bench kills checkpoints bombs repeat fuzz asan
#                           tsan
set -uo pipefail
cd "$(dirname "$0")/.."

all=(tests long numerics bench kills checkpoints bombs repeat fuzz asan tsan)
for step in "$@"; do
  [[ " ${all[*]} " == *" $step "* ]] || { echo "ci/nightly.sh: no step '$step'; there are ${all[*]}" >&2; exit 2; }
done
[ $# -gt 0 ] || set -- "${all[@]}"

program=build/release/bin/emberline
# Every test in its full length: as many samples, seeds and combinations as long_or_short() is given
# first (tests/support/long_tests.h).
long() { EMBERLINE_LONG_TESTS=1 ctest --preset release -j "$(nproc)"; }
bench() { cmake --build --preset release --target check_bench; }
# 100 kills of each driver: ctest has 14, of its first frames.
kills() { tests/farm/kills.py $program scenes --kills 300; }
checkpoints() {
  tests/farm/damage.py $program scenes --flips 1000 --stride 1 &&
    tests/farm/hostile.py $program scenes --mutations 1000 && tests/farm/outputs.py $program scenes
}
bombs() { tests/failure/bombs.py $program; }
# What acts at moments of a frame, again and again, beside as much other work as there are cores.
repeat() {
  local busy=() status=0
  for _ in $(seq "$(nproc)"); do
    while :; do :; done &
    busy+=($!)
  done
  ctest --preset release -j "$(nproc)" --repeat until-fail:20 \
    -R 'Stop|Signal|CalledOff|AtOnce|TimeLimit|Tev|Session|python_threads|farm_stops|farm_disk|session_|pictures_test' || status=1
  kill "${busy[@]}"
  return $status
}

cmake --preset release && cmake --build --preset release || exit 1
failed=()
for step in "$@"; do
  began=$SECONDS
  case $step in
    tests) ci/test.sh ;;
    numerics) ci/numerics.sh ;;
    fuzz) ci/fuzz.sh 600 ;;
    asan | tsan) ci/sanitize.sh "$step" ;;
    *) "$step" ;;
  esac || failed+=("$step")
  echo "ci/nightly.sh: $step took $(((SECONDS - began) / 60)) min"
done
[ ${#failed[@]} -eq 0 ] || { echo "ci/nightly.sh: failed: ${failed[*]}; again: ci/nightly.sh ${failed[*]}" >&2; exit 1; }
