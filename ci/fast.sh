#!/usr/bin/env bash
# Builds and runs the tests of the folders in which the working tree differs from a commit, by default the last commit:
#   ci/fast.sh [BASE]   e.g. ci/fast.sh main
# Use this script between two edits. It compiles without unity builds, so a changed file is rebuilt quickly. To test the
# effects on other folders, run ci/test.sh.
set -euo pipefail
cd "$(dirname "$0")/.."

base=${1:-HEAD}
git rev-parse --verify --quiet "$base^{commit}" >/dev/null || { echo "ci/fast.sh: no commit '$base'" >&2; exit 2; }
changed=$(git diff --name-only "$base" && git ls-files --others --exclude-standard)

# The check_ targets (tests/CMakeLists.txt) are named after the folders of the sources.
checks=() scripts=()
while read -r file; do
  case $file in
    *.md | "") ;;
    renderer/statistics/study/* | tests/unit/statistics/study/*) checks+=(study) ;;
    renderer/api/python/* | tests/python/*) scripts+=(python_) ;;
    renderer/*/* | tests/unit/*/*) file=${file#renderer/}; file=${file#tests/unit/}; checks+=("${file%%/*}") ;;
    io/blender/* | tests/blender/*) scripts+=(blender_) ;;
    io/* | samplers/* | integrators/*) checks+=("${file%%/*}") ;;
    tests/failure/*) checks+=(bad_input) ;;
    tests/farm/*) scripts+=(farm_) ;;
    tests/session/*) scripts+=(session_) ;;
    tests/view/*) scripts+=('window$') ;;
    tests/*/*) file=${file#tests/}; checks+=("${file%%/*}") ;;
    scenes/*) scripts+=(scenes.) ;;
    *) echo "ci/fast.sh: the folder of $file has no tests of its own; run ci/test.sh" ;;
  esac
done <<<"$changed"
mapfile -t checks < <(printf '%s\n' "${checks[@]}" | sort -u)
mapfile -t scripts < <(printf '%s\n' "${scripts[@]}" | sort -u)
[ -n "${checks[*]}${scripts[*]}" ] || { echo "ci/fast.sh: none of the files that differ from $base has tests"; exit 0; }

[ -f build/fast/build.ninja ] || cmake --preset fast
targets=()
for check in ${checks[*]}; do
  if ninja -C build/fast -t query "check_$check" >/dev/null 2>&1; then
    targets+=("check_$check")
  else
    echo "ci/fast.sh: $check has no tests of its own"
  fi
done
[ ${#targets[@]} -eq 0 ] || cmake --build --preset fast --target "${targets[@]}"
if [ -n "${scripts[*]}" ]; then
  cmake --build --preset fast
  ctest --preset fast -j "$(nproc)" -R "^($(IFS='|'; echo "${scripts[*]}"))"
fi
echo "ci/fast.sh: passed: ${targets[*]} ${scripts[*]}"
