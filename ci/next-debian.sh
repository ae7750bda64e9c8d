#!/usr/bin/env bash
# Builds and tests Emberline with the libraries of the next Debian release (which has Embree 4), in a root that
# debootstrap makes. Then builds, installs and tries the packages there. This script is run by hand, as root. It is not
# part of ci/test.sh.
#
#   ci/next-debian.sh [ROOT]      ROOT: the system's folder, reused if it exists (default build/next-debian;
#                                 about 3 GB; delete it to start afresh)
#
#   EMBERLINE_DEBIAN_MIRROR       the mirror of the packages (default: the mirror that this host's apt uses)
#   EMBERLINE_DEBIAN_SUITE        the Debian release (default: sid)
#   EMBERLINE_JOBS                parallel compilers and tests (default: one per processor)
set -euo pipefail
cd "$(dirname "$0")/.."

. ci/debian_root.sh

suite=${EMBERLINE_DEBIAN_SUITE:-sid}
jobs=${EMBERLINE_JOBS:-$(nproc)}
[ $# -le 1 ] || fail "at most one argument: the folder of the root"
mkdir -p "${1:-build}"
root=$(realpath "${1:-build/next-debian}")
make_root "$suite" "$root"

# Copies the working tree without ignored files. The copies keep their times, and the build folder is outside the copied
# tree, so a second run compiles only changed files.
rm -rf "$root/emberline"
mkdir "$root/emberline"
git ls-files -z --cached --others --exclude-standard |
  while IFS= read -r -d '' file; do
    if [ -e "$file" ]; then printf '%s\0' "$file"; fi
  done |
  tar --create --null --files-from=- | tar --extract --directory "$root/emberline"

in_root "$root" sh -c '
  set -e
  cd /emberline
  ci/setup.sh lintian mkdocs
  cmake --preset release -B /build/release
  cmake --build /build/release -j "$1"
  ctest --test-dir /build/release --output-on-failure -j "$1"

  rm -rf /build/package/packages
  cmake --preset package -B /build/package
  cmake --build /build/package --target package -j "$1"
  cd /build/package/packages
  lintian --allow-root ./*.deb
  apt-get install -y --no-install-recommends ./*.deb
  bash /emberline/ci/package/smoke.sh /emberline
  # shellcheck disable=SC2046
  apt-get purge -y $(for package in *.deb; do dpkg-deb -f "$package" Package; done)' build "$jobs"

echo
echo "ci/next-debian.sh: built and tested with"
in_root "$root" dpkg-query -W -f='${Package} ${Version}\n' g++ cmake libembree-dev libtbb-dev libimath-dev \
  libopenimageio-dev libopenexr-dev libopencolorio-dev libfreetype-dev libtinygltf-dev libdraco-dev libmeshoptimizer-dev \
  libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libgtest-dev
