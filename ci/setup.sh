#!/usr/bin/env bash
# Installs Emberline's dependencies and the packages given as arguments, on Debian 12 or later. Skips packages that are
# already installed.
#   ci/setup.sh [--program] [PACKAGE...]   --program: only what the program needs, nothing for Python and the tests
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache git pkg-config python3
  libembree-dev libtbb-dev libimath-dev
  libopenimageio-dev openimageio-tools libopenexr-dev libopencolorio-dev libpng-dev libjpeg-dev
  libfreetype-dev
  libtinygltf-dev libdraco-dev libmeshoptimizer-dev libzstd-dev
  libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev
  libglfw3-dev libimgui-dev
)
if [ "${1:-}" = --program ]; then
  shift
else
  packages+=(
    libgtest-dev libgmock-dev libbenchmark-dev
    pybind11-dev python3-dev python3-numpy
    xvfb xdotool libgl1-mesa-dri
    man-db zsh dpkg-dev
  )
fi
packages+=("$@")

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [ "$status" = installed ] || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || {
    echo "ci/setup.sh: missing packages: ${missing[*]}; install them, or run this as root" >&2
    exit 1
  }
  as_root=(sudo)
fi
echo "ci/setup.sh: installing ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { "${as_root[@]}" apt-get update && "${as_root[@]}" apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
  tail -n 20 "$log" >&2
  echo "ci/setup.sh: apt-get failed; the lines above say why" >&2
  exit 1
fi
