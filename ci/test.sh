#!/usr/bin/env bash
# Installs what a build needs, builds Emberline and runs its tests. `ci/test.sh asan` and `ci/test.sh tsan` do the same
# with sanitizers.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=${1:-release}
ci/setup.sh
cmake --preset "$preset" >build-configure.log 2>&1 || { cat build-configure.log >&2; exit 1; }
rm -f build-configure.log
cmake --build --preset "$preset"

# ci/farm.sh needs root, because only root can start Slurm's daemons.
if [ "$preset" = release ]; then
  if [ "$(id -u)" -eq 0 ]; then
    ci/farm.sh build/release/bin/emberline
  else
    echo "ci/test.sh: skipped ci/farm.sh, which needs root"
  fi
fi

# The numerics tests append one row per comparison to the file $rows. tests/numerics/table.csv must have the same
# comparisons (ci/numerics.sh).
rows=$(mktemp)
trap 'rm -f "$rows"' EXIT
# ctest runs one more test at a time than there are cores, because nine out of ten tests leave a core idle at times.
EMBERLINE_NUMERICS_TABLE=$rows ctest --preset "$preset" --no-tests=error -j "$(($(nproc) + 1))"
python3 tests/numerics/table.py "$rows" tests/numerics/table.csv >/dev/null
