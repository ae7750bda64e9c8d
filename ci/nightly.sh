#!/usr/bin/env bash
# Runs the long versions of tests that ci/test.sh runs only briefly. Then lists the steps that failed and the command
# that repeats them.
#   ci/nightly.sh [STEP...]   only these steps: tests long numerics bench kills checkpoints bombs repeat fuzz asan tsan
set -uo pipefail
cd "$(dirname "$0")/.."

all=(tests long numerics bench kills checkpoints bombs repeat fuzz asan tsan)
for step in "$@"; do
  [[ " ${all[*]} " == *" $step "* ]] || { echo "ci/nightly.sh: unknown step '$step'; valid steps are ${all[*]}" >&2; exit 2; }
done
[ $# -gt 0 ] || set -- "${all[@]}"

program=build/release/bin/emberline
# Runs every test at its full size: each long_or_short() then returns its first argument (tests/support/long_tests.h).
long() { EMBERLINE_LONG_TESTS=1 ctest --preset release -j "$(nproc)"; }
bench() { cmake --build --preset release --target check_bench; }
# Kills each of the three drivers 100 times. ctest kills each driver only 8 times.
kills() { EMBERLINE_LONG_TESTS=1 python3 tests/farm/kills.py $program scenes --kills 300; }
checkpoints() {
  export EMBERLINE_LONG_TESTS=1  # makes disk.py and stops.py run every case
  for script in "damage.py --flips 1000 --stride 1" "hostile.py --mutations 1000" outputs.py disk.py stops.py; do
    read -ra words <<< "$script"
    python3 "tests/farm/${words[0]}" $program scenes "${words[@]:1}" || return 1
  done
}
bombs() { python3 tests/failure/bombs.py $program; }
# Tests that measure time, stop a render, or watch one.
timed='Stop|Signal|AtOnce|TimeLimit|Timeout|OutOfTime|TimesAddUp|FirstSample|Snapshots|WantedPicture|Abandoned'
timed+='|Watched|StaticParts|WaitFor|Tev|Viewer|Session|Forecast|python_threads|farm_|session_|pictures_test|^window$'
# Repeats the tests that depend on timing. Meanwhile, every core is busy with other work.
repeat() {
  local busy=() status=0
  for _ in $(seq "$(nproc)"); do
    while :; do :; done &
    busy+=($!)
  done
  ctest --preset release -j "$(nproc)" --repeat until-fail:20 -R "$timed" || status=1
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
[ ${#failed[@]} -eq 0 ] || { echo "ci/nightly.sh: failed: ${failed[*]}; to repeat: ci/nightly.sh ${failed[*]}" >&2; exit 1; }
