#!/usr/bin/env bash
# Installs what a build needs, builds Emberline, renders one of the project's scenes and says where the pictures are.
# Arguments are options of `emberline render` and override the options below, e.g. ci/demo.sh --size 1920x1080.
set -euo pipefail
cd "$(dirname "$0")/.."

ci/setup.sh --program
cmake --preset release >build-configure.log 2>&1 || { cat build-configure.log >&2; exit 1; }
rm -f build-configure.log
cmake --build --preset release --target emberline

# The renderer takes samples where the error is largest, until the error is below 0.03 everywhere. The denoiser removes
# the remaining noise.
mkdir -p out
build/release/bin/emberline render scenes/teapot.glb -o out/teapot.exr -o out/teapot.png --size 800x450 \
  --driver adaptive --noise-threshold 0.03 --denoise --heatmap out/teapot.samples.png \
  --report out/teapot.json --report out/teapot.html "$@"
echo
echo "Pictures: out/teapot.png (look at it), out/teapot.exr (linear)"
echo "Where the samples went: out/teapot.samples.png"
echo "Report: out/teapot.html (open it in a browser), out/teapot.json"
