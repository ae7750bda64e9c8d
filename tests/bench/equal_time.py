#!/usr/bin/env python3
"""Compares `adaptive` with `bucket` at equal processor time, in squared displayed error.

A frame of `bucket` and a frame of `adaptive` with the same --spp are rendered and timed. Then `bucket` renders again,
with as many samples as fit into the time of `adaptive`. Prints for each scene and --spp:

  equal time   error of `adaptive` over that of `bucket` in the same time
  product      error times time of `adaptive` over that of `bucket` with the same --spp
  error, time  the two factors of the product

The two figures differ where the error of `bucket` does not halve when its time doubles, e.g. where most of the error is
in a few pixels with glints that are shown as white. The reference has two halves of --reference-spp samples, so that
its noise is subtracted. Each line of the file of scenes is a JSON object: {"name": "glass", "scene": "glass.glb",
"settings": {"sun": "30,40"}}. Paths are relative to the file.

  PYTHONPATH=build/release/python tests/bench/equal_time.py scenes.jsonl
"""
import argparse
import json
import math
import time
from pathlib import Path

import numpy as np

import emberline


def displayed(picture):
    """Returns the sRGB values of R, G and B, clipped to 0 to 1."""
    linear = np.clip(np.stack([picture[c] for c in "RGB"], -1).astype(float), 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def render(scene, spp, seed, driver):
    """Returns the displayed values, and the processor seconds of the faster of two runs."""
    runs = []
    for _ in range(2):
        began = time.process_time()
        picture = emberline.render(scene, spp=spp, seed=seed, driver=driver, threads=1)
        runs.append(time.process_time() - began)
    return displayed(picture), min(runs)


def compare(scene, reference, spp, seeds):
    """Returns sums over the seeds: errors of bucket, of adaptive, of bucket in the time of adaptive; two times."""
    a, b = reference
    sums = np.zeros(5)
    for seed in seeds:
        bucket, bucket_s = render(scene, spp, seed, "bucket")
        adaptive, adaptive_s = render(scene, spp, seed, "adaptive")
        equal, _ = render(scene, max(1, round(spp * adaptive_s / bucket_s)), seed, "bucket")
        errors = [((x - a) * (x - b)).mean() for x in (bucket, adaptive, equal)]
        sums += [*errors, bucket_s, adaptive_s]
    return sums


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=Path, help="file of scenes")
    parser.add_argument("--spp", default="16,64", help="samples per pixel [16,64]")
    parser.add_argument("--seeds", type=int, default=3, help="number of seeds [3]")
    parser.add_argument("--size", default="160x90", help="size of the frames [160x90]")
    parser.add_argument("--reference-spp", type=int, default=4096, help="samples of each half [4096]")
    parser.add_argument("--references", type=Path, help="folder that keeps the references for later runs")
    options = parser.parse_args()
    budgets = [int(word) for word in options.spp.split(",")]
    logs = {spp: [] for spp in budgets}
    print("| scene | spp | equal time | product | error | time |\n| --- | --- | --- | --- | --- | --- |")
    for line in options.scenes.read_text().splitlines():
        row = json.loads(line)
        settings = {k: str(options.scenes.parent / v) if k in ("env", "edits") else v
                    for k, v in row.get("settings", {}).items()}
        scene = emberline.Scene(options.scenes.parent / row["scene"], size=options.size, threads=1, **settings)
        kept = options.references and options.references / f"{row['name']}-{options.size}-{options.reference_spp}.npy"
        if kept and kept.exists():
            reference = np.load(kept)
        else:
            reference = np.stack([displayed(emberline.render(scene, spp=options.reference_spp, seed=seed))
                                  for seed in (901, 902)])
            if kept:
                np.save(kept, reference)
        for spp in budgets:
            e_bucket, e_adaptive, e_equal, t_bucket, t_adaptive = compare(scene, reference, spp,
                                                                          range(1, options.seeds + 1))
            equal, error, seconds = e_adaptive / e_equal, e_adaptive / e_bucket, t_adaptive / t_bucket
            logs[spp].append((math.log(max(equal, 1e-9)), math.log(max(error * seconds, 1e-9))))
            print(f"| {row['name']} | {spp} | {equal:.2f} | {error * seconds:.2f} | {error:.2f} | {seconds:.2f} |",
                  flush=True)
    for spp, values in logs.items():
        equal, product = np.exp(np.median(np.array(values), axis=0))
        print(f"| median | {spp} | {equal:.2f} | {product:.2f} | | |")


if __name__ == "__main__":
    main()
