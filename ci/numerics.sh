#!/usr/bin/env bash
# Compares the renderer with exact values and prints a table: case, exact value, measured value, its standard error, and
# the difference in standard errors. Fails if a comparison fails, or if tests/numerics/TABLE.md lists other comparisons
# than the tests make; `ci/numerics.sh --write` updates the table in that page.
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
  EMBERLINE_NUMERICS_TABLE=$rows build/release/bin/$program --gtest_brief=1 >>"$temporary/tests.log" 2>&1 || failed=1
done
[ $failed -eq 0 ] || cat "$temporary/tests.log" >&2
touch "$rows"
python3 tests/numerics/table.py "$rows" tests/numerics/TABLE.md "${write[@]}" || failed=1
exit $failed
