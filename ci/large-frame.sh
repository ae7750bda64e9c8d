#!/bin/sh
# Renders a 16384 x 16384 frame of the Cornell box with one sample per pixel. The process must use less than 1 GiB of
# resident memory: finished buckets are written and freed, so memory does not grow with the frame.
#
#   ci/large-frame.sh [SCENE.glb]
#
# This script is run by hand. It takes minutes, and up to 6 GB in $TMPDIR. Its figures come from the render's
# report.json.
set -eu
cd "$(dirname "$0")/.."
scene=${1:-scenes/cornell_box.glb}
emberline=build/release/bin/emberline
limit=1073741824

[ -x "$emberline" ] || { echo "build first: cmake --preset release && cmake --build --preset release" >&2; exit 2; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
trap 'exit 130' INT TERM

"$emberline" render "$scene" -o "$folder/frame.exr" --size 16384x16384 --spp 1 \
  --report "$folder/report.json"
python3 - "$folder" "$limit" <<'PYTHON'
import json, os, sys
folder, limit = sys.argv[1], int(sys.argv[2])
report = json.load(open(os.path.join(folder, "report.json")))
peak = report["memory"]["peak_rss_bytes"]
assert report["samples"]["total"] == 16384 * 16384 and report["exit_code"] == 0
print("peak %.0f MiB of at most %.0f, %.0f s, %.2f M samples/s, file %.2f GB" % (
    peak / 2**20, limit / 2**20, report["time"]["wall_s"],
    report["samples"]["total"] / report["time"]["render_s"] * 1e-6,
    os.path.getsize(os.path.join(folder, "frame.exr")) * 1e-9))
sys.exit(0 if peak < limit else 1)
PYTHON
