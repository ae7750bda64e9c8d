#!/usr/bin/python3
"""Shows where the samples went, and whether the error estimate was right.

    where_samples_went.py scenes/teapot.glb --size 320 180 --spp 32 -o samples.png

Renders adaptively, draws samples per pixel in false colours (blue: few, red: many), and compares the estimated error
with the error against a reference with 16 times the samples.
"""
import argparse

import numpy as np

import emberline

# The colours are blue, cyan, green, yellow and red.
COLOURS = np.array([[0.1, 0.1, 0.5], [0.0, 0.7, 0.9], [0.2, 0.7, 0.2], [1.0, 0.9, 0.1], [0.8, 0.0, 0.0]])


def false_colours(values):
    """Maps positive values to uint8 R G B on a logarithmic scale."""
    log = np.log2(np.maximum(values, 1))
    position = (log - log.min()) / max(np.ptp(log), 1e-6) * (len(COLOURS) - 1)
    steps = np.arange(len(COLOURS))
    colours = np.stack([np.interp(position, steps, COLOURS[:, c]) for c in range(3)], axis=-1)
    return np.rint(255 * colours).astype(np.uint8)


def blocks(values):
    """Returns the means of blocks of 8 x 8 pixels."""
    height, width = (n - n % 8 for n in values.shape[:2])
    return values[:height, :width].reshape(height // 8, 8, width // 8, 8, -1).mean(axis=(1, 3, 4)).ravel()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--size", type=int, nargs=2, default=(320, 180))
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("-o", "--output", default="samples.png")
    options = parser.parse_args()

    def progress(now):
        if now.error_estimate is not None:
            print(f"\r{now.samples / (options.size[0] * options.size[1]):6.1f} spp, error {now.error_estimate:.4f}", end="")

    scene = emberline.Scene(options.scene, size=options.size, spp=options.spp)
    picture = emberline.render(scene, driver="adaptive", aov="variance", progress=progress)
    print()
    samples = picture["samples"]
    emberline.write(options.output, false_colours(samples))
    sorted_samples = np.sort(samples, axis=None)[::-1]
    tenth = sorted_samples[: max(1, sorted_samples.size // 10)].sum() / sorted_samples.sum()
    print(f"{samples.min():.0f} to {samples.max():.0f} samples a pixel; a tenth of the pixels got {100 * tenth:.0f} %")

    # A single pixel's error and estimate are both noisy, so blocks of 8 x 8 pixels are compared.
    reference = emberline.render(scene, seed=999, spp=16 * options.spp)
    expected = blocks(picture["error"] ** 2)
    found = blocks((picture["RGB"] - reference["RGB"]) ** 2)
    order = np.array_split(np.argsort(expected), 8)
    print("expected RMS error:", *(f"{np.sqrt(expected[part].mean()):.4f}" for part in order))
    print("RMS error found:   ", *(f"{np.sqrt(found[part].mean()):.4f}" for part in order))


if __name__ == "__main__":
    main()
