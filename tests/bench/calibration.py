"""Checks adaptive sampling's own error estimate: prints its ratio to the true RMS error of the displayed
picture, for the gallery's scenes and several budgets, with adaptive_bench.

    python3 tests/bench/calibration.py build/release/bin/adaptive_bench [--size 96x54] [--seeds 8]
        [--reference-spp 4096] [--budgets 32,128,512] [--methods nested/display] [--scenes a,b]

The true error is the mean product of the frame's differences to two independent references, which
cancels the references' own noise. The goal is .8 to 1.25; the exit status is 1 if a ratio is outside.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
DUSK = ["--env", str(SCENES / "dusk.hdr")]
GALLERY = {"teapot": [], "cornell_box": [], "glass_metal": [], "thin_wires": DUSK, "spheres": [],
           "mis_plates": [], "night_street": ["--f-stop", "1.4", "--focus-distance", "1.2"],
           "caustics": []}
MIN_RATIO, MAX_RATIO = 0.8, 1.25


def measure(bench, scene, options, folder):
    out = pathlib.Path(folder) / f"{scene}.json"
    subprocess.run([bench, str(SCENES / f"{scene}.glb"), *GALLERY[scene], "--size", options.size,
                    "--budgets", options.budgets, "--methods", options.methods,
                    "--seeds", str(options.seeds), "--reference-spp", str(options.reference_spp),
                    "--json", str(out)], check=True, stdout=subprocess.DEVNULL)
    return json.loads(out.read_text())["methods"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("bench")
    parser.add_argument("--size", default="96x54")
    parser.add_argument("--budgets", default="32,128,512")
    parser.add_argument("--methods", default="nested/display")
    parser.add_argument("--scenes", default=",".join(GALLERY))
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--reference-spp", type=int, default=4096)
    options = parser.parse_args()
    budgets = options.budgets.split(",")
    outside = 0
    print("| scene, method | " + " | ".join(budgets) + " |\n| --- |" + " --- |" * len(budgets))
    with tempfile.TemporaryDirectory() as folder:
        for scene in options.scenes.split(","):
            result = measure(options.bench, scene, options, folder)
            for method in options.methods.split(","):
                ratios = [result[budget][method]["calibration"] for budget in budgets]
                outside += sum(not MIN_RATIO <= ratio <= MAX_RATIO for ratio in ratios)
                print(f"| `{scene}`, {method} | " + " | ".join(f"{r:.2f}" for r in ratios) + " |",
                      flush=True)
    return 1 if outside else 0


if __name__ == "__main__":
    sys.exit(main())
