#!/usr/bin/env bash
# Cross-compiles for 64-bit ARM against the libraries of Debian 12. Then runs renders and the named test programs under
# qemu-user. This script is run by hand. It needs network access, and installs mmdebstrap.
#   ci/cross.sh [--root FOLDER] [TEST_PROGRAM...]    FOLDER: where the libraries are (1.0 GB), reused if it exists
#                                                    (default build/arm64-root)
set -euo pipefail
cd "$(dirname "$0")/.."
. ci/debian_root.sh

folder=build/arm64-root
if [ "${1:-}" = --root ]; then
  [ $# -ge 2 ] || fail "--root needs a folder"
  folder=$2
  shift 2
fi
grep -q '^VERSION_ID="12"' /etc/os-release ||
  fail "this script needs Debian 12, because it links the program with Debian 12's libraries"
ci/setup.sh mmdebstrap g++-aarch64-linux-gnu qemu-user
mkdir -p "$folder"
folder=$(realpath "$folder")
log=$(mktemp)
trap 'rm -f "$log"' EXIT

# Installs the development packages that setup.sh installs, and packages with programs that their CMake files name.
if [ ! -e "$folder/whole" ]; then
  echo "ci/cross.sh: unpacking Debian's libraries for arm64 into $folder"
  rm -rf "$folder/root"
  wanted=$(sed -n '/packages.*=($/,/^ *)$/p' ci/setup.sh | grep -oE '[a-z0-9+.-]+-dev' | grep -vE '^(dpkg|python3|pybind11)-dev$' | paste -sd ,)
  mmdebstrap --variant=extract --architectures=arm64 --aptopt='Acquire::Check-Valid-Until "false"' \
    --include="draco,openimageio-tools,libc6-dev,libstdc++-12-dev,$wanted" bookworm "$folder/root" >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    fail "mmdebstrap failed (no network?); the lines above say why"
  }
  # The installed packages are not configured. OpenColorIO's CMake file looks for lib and include beside the root, and
  # other packages' CMake files name folders in /usr.
  ln -sfn root/usr/lib "$folder/lib"
  ln -sfn root/usr/include "$folder/include"
  grep -rlE '"/usr/(lib|include)' "$folder/root/usr/lib/aarch64-linux-gnu/cmake" "$folder/root/usr/share/cmake" |
    xargs sed -i -E "s|([\";])/usr/(lib\|include)|\1$folder/root/usr/\2|g"
  touch "$folder/whole"
fi

export EMBERLINE_SYSROOT=$folder/root
{ cmake --preset arm64 && cmake --build --preset arm64 --target emberline "$@"; } >"$log" 2>&1 || {
  tail -n 30 "$log" >&2
  fail "the build failed; the lines above say why"
}
libraries=$folder/root/usr/lib/aarch64-linux-gnu
arm() { qemu-aarch64 -L "$folder/root" -E "LD_LIBRARY_PATH=$libraries/blas:$libraries/lapack" "$@"; }
arm build/arm64/bin/emberline --version
for program in "$@"; do arm "build/arm64/bin/$program" --gtest_brief=1; done

# The pictures rendered for ARM must match those that this machine renders, up to rounding.
[ -x build/release/bin/emberline ] || { cmake --preset release && cmake --build --preset release --target emberline; } >"$log" 2>&1
for scene in cornell_box teapot; do
  words=(render "scenes/$scene.glb" --size 96x64 --spp 16 --quiet)
  arm build/arm64/bin/emberline "${words[@]}" -o "build/arm64/$scene.exr"
  build/release/bin/emberline "${words[@]}" -o "build/arm64/$scene.here.exr"
  build/release/bin/emberline compare "build/arm64/$scene.exr" "build/arm64/$scene.here.exr" --json >"$log"
  python3 - "$scene" "$log" <<'PYTHON'
import json, sys
error = json.load(open(sys.argv[2]))
print(f"{sys.argv[1]}: relMSE {error['relmse_trimmed']:.1e} without the worst 0.1 %, {error['different_pixels']} pixels differ")
sys.exit(error["relmse_trimmed"] > 1e-4)
PYTHON
done
echo "ci/cross.sh: compiled for arm64; the pictures match those rendered by this machine"
