#!/usr/bin/python3
"""Runs a study that shows which driver reaches a small error first.

    speed_against_error.py scenes/cornell_box.glb --folder /tmp/study

Renders the scene with each driver, several budgets and seeds, compares the pictures with a reference, and prints each
method's mean error and time. The folder also gets study.html; running a stopped study again resumes it.
"""
import argparse
from collections import defaultdict

import numpy as np

import emberline


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--folder", required=True)
    parser.add_argument("--drivers", nargs="+", default=["bucket", "adaptive"])
    parser.add_argument("--budgets", type=int, nargs="+", default=[4, 16, 64], help="samples per pixel")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--size", type=int, nargs=2, default=(160, 90))
    options = parser.parse_args()
    table = emberline.study(
        options.scene, options.folder, drivers=options.drivers, spp=options.budgets, seeds=options.seeds,
        size=options.size,
    )
    runs = defaultdict(list)
    for row in table.rows:
        if not row["failure"]:
            runs[row["method"], row["budget"]].append((row["relmse"], row["cpu_s"]))
    print(f"{'method':24}{'budget':>8}{'relmse':>12}{'cpu s':>10}")
    for (method, budget), values in runs.items():
        error, seconds = np.mean(values, axis=0)
        print(f"{method:24}{budget:8g}{error:12.3g}{seconds:10.3g}")


if __name__ == "__main__":
    main()
