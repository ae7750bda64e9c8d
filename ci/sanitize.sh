#!/usr/bin/env bash
# Builds and runs the tests under sanitizers: `ci/sanitize.sh asan` for AddressSanitizer with LeakSanitizer and
# UndefinedBehaviorSanitizer, `ci/sanitize.sh tsan` for ThreadSanitizer. Without an argument it runs both.
# CMakePresets.json has the flags, ci/tsan.supp the suppressions and their reasons.
set -euo pipefail
cd "$(dirname "$0")/.."

[ $# -gt 0 ] || set -- asan tsan
for preset; do
  case $preset in
    asan | tsan) ;;
    *)
      echo "ci/sanitize.sh: unknown sanitizer '$preset'; valid names are asan, tsan" >&2
      exit 2
      ;;
  esac
done
for preset; do
  echo "ci/sanitize.sh: $preset"
  ci/test.sh "$preset"
done
