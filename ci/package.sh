#!/usr/bin/env bash
# Builds the packages. Then installs them in a minimal Debian 12, tries them (ci/package/smoke.sh) and removes them. No
# file may be left behind there. This script needs root, network access, and a Debian 12 to build on.
#   ci/package.sh [ROOT]   ROOT: the minimal system's folder, reused if it exists (default build/package-root,
#                          0.3 GB); the packages are tried in its copy, ROOT.try
set -euo pipefail
cd "$(dirname "$0")/.."
. ci/debian_root.sh

[ $# -le 1 ] || fail "at most one argument: the folder of the root"
{ grep -q '^VERSION_ID="12"' /etc/os-release && [ "$(id -u)" -eq 0 ]; } || fail "needs Debian 12, root and network"
ci/setup.sh debootstrap lintian mkdocs
mkdir -p "${1:-build}"
root=$(realpath "${1:-build/package-root}")
make_root bookworm "$root"

packages=build/package/packages
rm -rf "$packages"
log=$(mktemp)
trap 'rm -rf "$log" "$log.before" "$log.after" "$root.try"' EXIT
{ cmake --preset package && cmake --build --preset package; } >"$log" 2>&1 || {
  tail -n 30 "$log" >&2
  fail "the packages were not built; the lines above say why"
}
ls -l "$packages"
lintian --allow-root "$packages"/*.deb || fail "lintian finds errors"

rm -rf "$root.try"
cp -a "$root" "$root.try"
mkdir -p "$root.try/emberline/tests"
cp -r scenes ci/package/smoke.sh "$packages" "$root.try/emberline"
cp -r tests/install "$root.try/emberline/tests"

# Runs a command in the copy of the root. Shows the command's output only if the command fails.
quietly() {
  in_root "$root.try" "$@" >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    fail "$1 $2 failed in the bare root (no network?); the lines above say why"
  }
}
files_of_root() {
  (cd "$root.try" && find . \( -path ./tmp -o -path ./var/cache/apt -o -path ./var/log \) -prune -o -print | sort)
}
# Install the dependencies before listing the files, so that only our packages can cause differences between the lists.
depends=$(for package in "$packages"/*.deb; do dpkg-deb -f "$package" Depends; done |
  tr ',' '\n' | grep -v emberline | paste -sd ,)
quietly apt-get update
quietly apt-get satisfy -y --no-install-recommends "$depends, g++, cmake, make, pkg-config"
files_of_root >"$log.before"
quietly sh -c 'apt-get install -y --no-install-recommends /emberline/packages/*.deb'
in_root "$root.try" bash /emberline/smoke.sh /emberline || fail "the installed command fails"
# shellcheck disable=SC2046
quietly apt-get purge -y $(for package in "$packages"/*.deb; do dpkg-deb -f "$package" Package; done)
files_of_root >"$log.after"
diff "$log.before" "$log.after" || fail "removing the packages left these files (>), or removed other files (<)"
echo "ci/package.sh: built, installed, tried and removed cleanly"
