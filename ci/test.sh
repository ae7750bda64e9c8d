#!/usr/bin/env bash
# Sets up, builds and tests. `ci/test.sh asan` and `ci/test.sh tsan` do the same with sanitizers.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=${1:-release}
ci/setup.sh
cmake --preset "$preset" >build-configure.log 2>&1 || { cat build-configure.log >&2; exit 1; }
rm -f build-configure.log
cmake --build --preset "$preset"
ctest --preset "$preset" -j "$(nproc)"
# The table of exact values: the page that shows it must hold today's comparisons. A sanitizer's
# build makes the same ones.
if [ "$preset" = release ]; then ci/numerics.sh >/dev/null; fi
