#!/usr/bin/env bash
# Compares frames with exact values. Each comparison has a case, an exact value, a measured value with its standard
# error, and the deviation in standard errors. `ci/numerics.sh` prints a summary, and the worst comparison of each test.
# It fails if a comparison fails, or if tests/numerics/table.csv does not have the same comparisons as the tests.
# `ci/numerics.sh --write` rewrites tests/numerics/table.csv.
set -euo pipefail
cd "$(dirname "$0")/.."

write=()
case ${1-} in
  '') ;;
  --write) write=(--write) ;;
  *)
    echo "ci/numerics.sh: unknown option '$1'; the only one is --write" >&2
    exit 2
    ;;
esac

temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
ci/setup.sh
log=$temporary/build.log
if ! { cmake --preset release && cmake --build --preset release --target numerics_test bad_texels_test; } >"$log" 2>&1; then
  cat "$log" >&2
  exit 1
fi

rows=$temporary/rows.jsonl
failed=0
for program in numerics_test bad_texels_test; do
  EMBERLINE_LONG_TESTS=1 EMBERLINE_NUMERICS_TABLE=$rows build/release/bin/$program --gtest_brief=1 >>"$temporary/tests.log" 2>&1 || failed=1
done
[ $failed -eq 0 ] || cat "$temporary/tests.log" >&2
touch "$rows"
python3 tests/numerics/table.py "$rows" tests/numerics/table.csv "${write[@]}" || failed=1
exit $failed
