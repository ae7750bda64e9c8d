#!/usr/bin/env python3
"""Measures whether the channels that `judge` names reach their thresholds.

For each scene, channel and threshold, prints the RMS error of the channel in the frame that judges R G B alone and in
the frame that also judges the channel, as multiples of the threshold, and the samples of the second frame over those of
the first. Errors are as the setting measures them: of layers of light as displayed, of Z as a fraction, otherwise in the
channel's unit, and at silhouettes in proportion to the coverage. Each reference is two frames with half the samples, so that its noise is subtracted.

  PYTHONPATH=build/release/python tests/bench/judged_channels.py
"""
import argparse
from pathlib import Path

import numpy as np

import emberline

SCENES = Path(__file__).parents[2] / "scenes"
LAYERS = "albedo,N,Z,ao,direct,indirect,reflection"
VIEWS = {
    "cornell_box": {"transparent": "yes"},
    "cornell_box, shadow on the floor": {"catcher": "floor", "transparent": "yes"},
    "spheres": {"transparent": "yes"},
    "spheres, shadow on the paper": {"catcher": "paper", "transparent": "yes"},
    "mis_plates": {"transparent": "yes"},
    "shallow_focus": {"transparent": "yes"},
    "moving_blade": {"transparent": "yes"},
}


def displayed(linear):
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def values(picture, name):
    """Returns the values of a channel, as its error is measured: (pixels, components)."""
    layers = [layer for layer in picture.layers if layer == name or name == "light.*" and layer.startswith("light.")]
    planes = np.concatenate([np.asarray(picture[layer], float).reshape(len(picture["A"].ravel()), -1)
                             for layer in layers], -1)
    return displayed(planes) if name in ("light.*", "direct", "indirect", "reflection") else planes


def rms_error(picture, halves, name, coverage):
    x, a, b = (values(p, name) for p in (picture, *halves))
    if name == "Z":
        scale = np.maximum(np.abs(a + b) / 2, 1e-9)
        x, a, b = (np.clip(v / scale, 0, 2) for v in (x, a, b))
    squares = (x - a) * (x - b)
    if name in ("Z", "ao", "shadow"):
        squares *= coverage.reshape(-1, 1) ** 2
    if name == "light.*":  # the group with the largest error counts
        return float(np.sqrt(max(0.0, squares.reshape(len(squares), -1, 3).mean((0, 2)).max())))
    return float(np.sqrt(max(0.0, squares.mean())))


def samples(picture):
    return float(np.mean(picture["samples"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--thresholds", default="0.02,0.01", help="thresholds [0.02,0.01]")
    parser.add_argument("--size", default="160x90", help="size of the frames [160x90]")
    parser.add_argument("--reference-spp", type=int, default=2048, help="samples of each half [2048]")
    options = parser.parse_args()
    print("| scene | channel | threshold | R G B alone | judged | samples |\n| --- | --- | --- | --- | --- | --- |")
    for name, settings in VIEWS.items():
        settings = {"aov": LAYERS, "light-groups": "yes", **settings}
        scene = emberline.Scene(SCENES / f"{name.split(',')[0]}.glb", size=options.size,
                                **{k.replace("-", "_"): v for k, v in settings.items()})
        halves = [emberline.render(scene, spp=options.reference_spp, seed=seed) for seed in (901, 902)]
        held = {"holdout": settings["catcher"]} if "catcher" in settings else {}
        objects = emberline.Scene(SCENES / f"{name.split(',')[0]}.glb", size=options.size, transparent="yes", **held)
        coverage = np.asarray(emberline.render(objects, spp=options.reference_spp, max_depth=1)["A"], float)
        if "catcher" in settings:
            coverage = 1 - coverage
        channels = ["A", "shadow"] if "catcher" in settings else LAYERS.split(",") + ["light.*", "A"]
        for threshold in options.thresholds.split(","):
            def frame(judge):
                return emberline.render(scene, driver="adaptive", noise_threshold=threshold, judge=judge)
            alone = frame("RGB")
            for channel in channels:
                judged = frame(f"RGB,{channel}")
                before, after = (rms_error(p, halves, channel, coverage) / float(threshold) for p in (alone, judged))
                print(f"| {name} | {channel} | {threshold} | {before:.2f} | {after:.2f} | "
                      f"{samples(judged) / samples(alone):.2f} |", flush=True)


if __name__ == "__main__":
    main()
