#!/usr/bin/env bash
# Sets up, builds, renders the project's own scene and says where the pictures are.
set -euo pipefail
cd "$(dirname "$0")/.."

ci/setup.sh
cmake --preset release >build-configure.log 2>&1 || { cat build-configure.log >&2; exit 1; }
rm -f build-configure.log
cmake --build --preset release --target emberline

mkdir -p out
build/release/bin/emberline render scenes/teapot.glb \
  -o out/teapot.exr -o out/teapot.png --spp 128 --report out/teapot.json --report out/teapot.html "$@"
echo
echo "Pictures: out/teapot.png (look at it), out/teapot.exr (linear)"
echo "What it took: out/teapot.html (in a browser), out/teapot.json"
