#!/usr/bin/python3
"""Relights a scene without new rays: light is additive, so pictures that are lit by one lamp each can be mixed.

    relight.py scenes/teapot.glb --lamps window fill --weights 0.3 2 -o relit.png

Renders the scene once for each lamp, with the other lamps switched off by an edit, and mixes the pictures with NumPy.
Then, for comparison, renders the scene with an edit that sets the weights.
"""
import argparse

import emberline


def lamp(scene, name, **change):
    """Returns the edits' entry for one of the file's lights or emissive materials, with `change` applied."""
    for light in scene.editable["lights"]:
        if light.get("name") == name:
            return {**light, **change}
    raise SystemExit(f"no lamp {name!r}; the scene has {', '.join(scene.lights)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--lamps", nargs="+", required=True, help="names of lights or emissive materials")
    parser.add_argument("--weights", type=float, nargs="+", required=True, help="one weight for each lamp")
    parser.add_argument("--size", type=int, nargs=2, default=(320, 180))
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("-o", "--output", default="relit.png")
    options = parser.parse_args()
    if len(options.weights) != len(options.lamps):
        parser.error("--weights needs one weight for each lamp")

    scene = emberline.Scene(options.scene, size=options.size, spp=options.spp)
    def lit_by(*lamps):
        scene.edit({"lights": [lamp(scene, name, on=name in lamps) for name in options.lamps]})
        return emberline.render(scene)["RGB"]

    unnamed_light = lit_by()  # the light of everything except the named lamps
    lamp_pictures = [lit_by(name) - unnamed_light for name in options.lamps]
    mixed = unnamed_light + sum(weight * picture for weight, picture in zip(options.weights, lamp_pictures))
    emberline.write(options.output, mixed)

    scene.edit({"lights": [lamp(scene, n, intensity=w) for n, w in zip(options.lamps, options.weights)]})
    rendered = emberline.render(scene)
    errors = emberline.compare(mixed, rendered)
    everything = unnamed_light.mean() + sum(picture.mean() for picture in lamp_pictures)
    shares = (f"{name} {100 * picture.mean() / everything:.0f} %" for name, picture in zip(options.lamps, lamp_pictures))
    print("share of the light:", ", ".join(shares))
    print(f"mixed against rendered: PSNR {errors.psnr:.1f} dB, signed bias {100 * errors.signed_bias:+.2f} %")


if __name__ == "__main__":
    main()
