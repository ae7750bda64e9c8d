#!/usr/bin/env bash
# Holds the renderer against exact values and makes the table of it: case, exact value, measured
# value, its standard error, how many of them it is off. `ci/numerics.sh` prints the table and fails
# when a comparison does, or when tests/numerics/TABLE.md has other comparisons than the tests make;
# `ci/numerics.sh --write` renews the table in that page. The tests run in their full length.
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
python3 tests/numerics/table.py "$rows" tests/numerics/TABLE.md "${write[@]}" || failed=1
exit $failed
