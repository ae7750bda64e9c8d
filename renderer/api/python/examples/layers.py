#!/usr/bin/python3
"""Makes layers for compositing: a relit picture, a mask of one object, a denoised picture and a heatmap of the samples.

    layers.py scenes/teapot.glb --lamp window --weight 0.3 --object teapot -o shot

Renders the scene once, with light groups, Cryptomatte and denoising. Writes shot.exr with all layers, as the command
does; shot_relit.png with one lamp brighter or darker; shot_mask.png with the object's mask; and shot_samples.png, a
heatmap.
"""
import argparse

import numpy as np

import emberline


def mask_of(picture, layer, identity):
    """Returns how much of each pixel the id covers, summed over all ranks."""
    coverage = np.zeros(picture["A"].shape, np.float32)
    for name in picture.layers:
        if not name.startswith(layer):
            continue
        ranks = np.ascontiguousarray(picture[name])
        for rank in range(0, ranks.shape[-1], 2):
            coverage += np.where(ranks[..., rank].view(np.uint32) == identity, ranks[..., rank + 1], 0)
    return coverage


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--lamp", required=True, help="a light's layer, without \"light.\"")
    parser.add_argument("--weight", type=float, default=0.5)
    parser.add_argument("--object", required=True, help="a node of the scene")
    parser.add_argument("--size", type=int, nargs=2, default=(320, 180))
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("-o", "--output", default="shot")
    options = parser.parse_args()

    scene = emberline.Scene(
        options.scene, size=options.size, spp=options.spp, light_groups=True, cryptomatte="object", denoise=True
    )
    picture = emberline.render(scene)
    emberline.write(options.output + ".exr", picture)

    # Light is additive, with or without denoising.
    lights = [name for name in picture.layers if name.startswith("denoised.light.")]
    weights = {f"denoised.light.{options.lamp}": options.weight}
    relit = sum(weights.get(name, 1) * picture[name] for name in lights)
    emberline.write(options.output + "_relit.png", relit)

    identity = emberline.matte_names(scene)["CryptoObject"][options.object]
    mask = mask_of(picture, "CryptoObject", identity)
    emberline.write(options.output + "_mask.png", np.repeat(mask[..., None], 3, axis=-1))
    emberline.write(options.output + "_samples.png", emberline.heatmap(picture, "samples", colors="viridis"))

    print("lights:", ", ".join(name.removeprefix("denoised.light.") for name in lights))
    print(f"{options.object} covers {100 * mask.mean():.1f} % of the picture")
    print(f"expected error after denoising: {np.sqrt((picture['denoised.error'] ** 2).mean()):.2g}")


if __name__ == "__main__":
    main()
