#!/usr/bin/python3
"""Measures how the error falls with the sample count, for each driver and sampler.

    error_against_samples.py scenes/cornell_box.glb --size 160 120 --spp 1 4 16 64

The reference is independent of the measured pictures: it uses the independent sampler, another seed, and 16 times the
largest sample count. The last column is the slope in a log-log plot; independent samples have a slope of -1.
"""
import argparse

import numpy as np

import emberline


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--size", type=int, nargs=2, default=(160, 120))
    parser.add_argument("--spp", type=int, nargs="+", default=[1, 4, 16, 64])
    parser.add_argument("--drivers", nargs="+", default=["bucket", "adaptive"])
    parser.add_argument("--samplers", nargs="+", default=["independent", "sobol"])
    parser.add_argument("--seeds", type=int, default=3, help="number of pictures over which each error is averaged")
    options = parser.parse_args()

    scene = emberline.Scene(options.scene, size=options.size)
    reference = emberline.render(scene, sampler="independent", seed=999, spp=16 * max(options.spp))

    print(f"{'relMSE without the worst 0.1 %':32}", *(f"{spp:>9} spp" for spp in options.spp), "    slope")
    for driver in options.drivers:
        for sampler in options.samplers:
            errors = []
            for spp in options.spp:
                pictures = (
                    emberline.render(scene, driver=driver, sampler=sampler, spp=spp, seed=seed)
                    for seed in range(options.seeds)
                )
                errors.append(np.mean([emberline.compare(p, reference).relmse_trimmed for p in pictures]))
            slope = np.polyfit(np.log(options.spp), np.log(errors), 1)[0] if len(errors) > 1 else float("nan")
            print(f"{driver + ', ' + sampler:32}", *(f"{error:13.3g}" for error in errors), f"{slope:9.2f}")


if __name__ == "__main__":
    main()
