#!/usr/bin/python3
"""Uses checkpoints: stops and resumes a frame, extends it, and renders it in parts.

    resume_and_merge.py scenes/cornell_box.glb --folder /tmp/frames

Stops a frame half-way and resumes it. Doubles its samples with extend(). Renders and merges two parts, as two machines
would. All results have the same bits as a frame rendered in one go.
"""
import argparse
from pathlib import Path

import numpy as np

import emberline


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--folder", type=Path, required=True, help="existing folder for the checkpoints")
    parser.add_argument("--size", type=int, nargs=2, default=(320, 180))
    parser.add_argument("--spp", type=int, default=32)
    options = parser.parse_args()
    scene = emberline.Scene(options.scene, size=options.size, spp=options.spp, bucket_size=16)
    reference = emberline.render(scene)
    half_samples = reference.samples / 2

    file = options.folder / "frame.checkpoint"
    half = emberline.render(scene, checkpoint=file, progress=lambda now: now.samples < half_samples)
    resumed = emberline.render(scene, checkpoint=file, resume=True, keep_checkpoint=True)
    print(f"stopped after {half.samples} of {reference.samples} samples, and resumed")

    extended = emberline.extend(file, scene, spp=2 * options.spp)
    print(f"extended to {emberline.stored_frame(file).settings['spp']} samples a pixel")

    parts = [options.folder / f"part_{k}.checkpoint" for k in (1, 2)]
    for k, part in enumerate(parts, 1):
        emberline.render(scene, part=f"{k}/2", checkpoint=part)
    merged = emberline.merge(parts, parts=True)
    print(f"merged: {(merged['part'] == 1).mean():.0%} of the pixels come from the first part")

    rendered_at_once = emberline.render(scene, spp=2 * options.spp)
    same = [np.array_equal(a.pixels, b.pixels) for a, b in ((resumed, reference), (extended, rendered_at_once))]
    same.append(np.array_equal(merged["RGBA"], reference["RGBA"]))
    print("the same bits:", *same)


if __name__ == "__main__":
    main()
