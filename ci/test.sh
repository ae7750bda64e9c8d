#!/usr/bin/env bash
# Sets up, builds and tests. `ci/test.sh asan` and `ci/test.sh tsan` do the same with sanitizers.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=${1:-release}
ci/setup.sh
cmake --preset "$preset" >build-configure.log 2>&1 || { cat build-configure.log >&2; exit 1; }
rm -f build-configure.log

# ci/farm.sh needs root, because only root can start Slurm's daemons. It mostly waits for Slurm, so it runs while the
# tests are compiled.
farm=
farm_log=$(mktemp) rows=$(mktemp)
finish() {
  trap '' INT TERM HUP
  if [ -n "$farm" ]; then
    kill "$farm" 2>/dev/null || true
    wait "$farm" || true
  fi
  rm -f "$farm_log" "$rows"
}
trap finish EXIT
trap 'exit 130' INT TERM HUP
if [ "$preset" = release ]; then
  if [ "$(id -u)" -eq 0 ]; then
    ci/setup.sh slurm-wlm munge
    cmake --build --preset "$preset" --target emberline
    ci/farm.sh build/release/bin/emberline >"$farm_log" 2>&1 &
    farm=$!
  else
    echo "ci/test.sh: skipped ci/farm.sh, which needs root"
  fi
fi
cmake --build --preset "$preset"
if [ -n "$farm" ]; then
  status=0
  wait "$farm" || status=$?
  farm=
  [ "$status" -eq 0 ] || { cat "$farm_log" >&2; echo "ci/test.sh: ci/farm.sh failed" >&2; exit 1; }
  tail -n 1 "$farm_log"
fi

# The numerics tests append one row per comparison. tests/numerics/table.csv must have the same comparisons
# (ci/numerics.sh). Runs one job more than there are cores, because nine in ten tests leave a core idle at times.
EMBERLINE_NUMERICS_TABLE=$rows ctest --preset "$preset" --no-tests=error -j "$(($(nproc) + 1))"
python3 tests/numerics/table.py "$rows" tests/numerics/table.csv >/dev/null
