#!/usr/bin/env python3
"""Makes pictures of the gallery:

  figure_1_spheres.jpg, figure_1_teapot.jpg   a picture on the left, its sample density on the right
  blur.jpg       pictures and sample densities with motion blur, with depth of field, and with both
  heatmaps.jpg   samples, stop reasons, time and error of one frame
  clamped.jpg    a picture without and with --clamp-indirect, and the light that --clamp-indirect removed
  guided.jpg     a room without and with --env-sampling guided, a corridor without and with --guiding on, and savings
  denoised.jpg   a picture of 16 samples, the denoised picture, its estimated error, and a picture of 4096 samples
  layers.jpg     a frame's layers for compositing

    make_heatmaps.py [--emberline BINARY] [--out DIR] [--size WxH] [--threads N] [--only NAME,...]

The first two follow figure 1 of J. Painter and K. Sloan, "Antialiased ray tracing by adaptive progressive refinement",
SIGGRAPH 1989. They show direct light. Every pixel is refined until its error is small enough, and the sample density is
shown in grey.

The script needs oiiotool (Debian: openimageio-tools) to put pictures side by side.
"""

import argparse
import pathlib
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tests/bench"))
import interiors  # noqa: E402
SCENES = ["spheres", "teapot"]
# The noise threshold is 1/100 of the display's range. Both figures use the same scale, in which 400 or more samples are
# white.
OPTIONS = ["--driver", "adaptive", "--integrator", "direct", "--noise-threshold", "0.01", "--range", "0,400"]
# blur.jpg has three rows, so its pictures have half the gallery's size of 800x450. Pixels with at least three times the
# mean number of samples are white.
BLUR = ["--driver", "adaptive", "--spp", "64", "--range", "0,192", "--size", "400x225"]
SHUTTER = ["--time", "0", "--shutter", "0,0.5"]
LENS = ["--f-stop", "0.5", "--focus-distance", "1.27"]  # the camera focuses on the books
# For heatmaps.jpg: FRAME has the options of the frame, and HEATMAPS has the quantity and the style of each heatmap.
FRAME = ["--driver", "adaptive", "--noise-threshold", "0.02", "--max-spp", "256", "--size", "640x360"]
HEATMAPS = [["samples", "--colors", "viridis"], ["stop"], ["time", "--colors", "turbo"],
            ["error", "--log", "--colors", "inferno"]]
JPEG = ["--eraseattrib", ".*", "--nosoftwareattrib", "--attrib", "oiio:ColorSpace", "sRGB", "--compression", "jpeg:85",
        "-d", "uint8", "-o"]
DEPTHS = ["0.5", "2"]  # in metres: the depth that is black, and how much farther away white is
OBJECTS = "20"
BACKGROUND = "0.118,0.118,0.118"  # the legend's colour


def png_size(path):
    with open(path, "rb") as file:
        return struct.unpack(">II", file.read(24)[16:24])


def run(*words):
    subprocess.run([str(word) for word in words], check=True)


def make_figure(emberline, scene, rows, out):
    """Writes a picture with one row for each entry of `rows`, which are render options. A row shows the image on the
    left and its sample density on the right."""
    with tempfile.TemporaryDirectory() as folder:
        stack, pastes, top = [], [], 0  # oiiotool pastes the top of the stack first
        for number, options in enumerate(rows):
            picture, density = (pathlib.Path(folder) / f"{name}{number}.png" for name in ("picture", "density"))
            run(emberline, "render", HERE / f"{scene}.glb", "-o", picture, "--heatmap", density, "--quiet", *options)
            (left, _), (right, height) = png_size(picture), png_size(density)
            stack = [density, picture, *stack]
            pastes += ["--paste", f"+0+{top}", "--paste", f"+{left}+{top}"]
            top += height
        canvas_size = f"{left + right}x{top}"
        run("oiiotool", *stack, "--create", canvas_size, 3, f"--fill:color={BACKGROUND}", canvas_size, *pastes, *JPEG, out)


def make_heatmaps(emberline, threads, out):
    with tempfile.TemporaryDirectory() as folder:
        frame = pathlib.Path(folder) / "frame.exr"
        run(emberline, "render", HERE / "spheres.glb", "-o", frame, "--aov", "variance,stop,time", "--threads", threads,
            "--quiet", *FRAME)
        pictures = [pathlib.Path(folder) / f"{of[0]}.png" for of in HEATMAPS]
        for picture, of in zip(pictures, HEATMAPS):
            run(emberline, "heatmap", frame, "-o", picture, "--quiet", "--of", *of)
        run("oiiotool", *pictures, "--mosaic:pad=8", "2x2", *JPEG, out)


def make_clamped(emberline, threads, out):
    """Writes an image without and with clamped indirect light, and the light that clamping removes."""
    with tempfile.TemporaryDirectory() as folder:
        frame, clamped = pathlib.Path(folder) / "frame.exr", pathlib.Path(folder) / "clamped.exr"
        render = [emberline, "render", HERE / "glass_metal.glb", "--size", "400x225", "--spp", "64", "--quiet", *threads]
        run(*render, "-o", frame)
        run(*render, "-o", clamped, "--clamp-indirect", "4", "--aov", "clamped")
        panels = []
        for source, layer in ((frame, ""), (clamped, ""), (clamped, "clamped.")):
            panels.append(pathlib.Path(folder) / f"{len(panels)}.png")
            channels = ",".join(f"{name}={layer}{name}" for name in "RGB")
            run("oiiotool", source, "--ch", channels, "--colorconvert", "linear", "sRGB", "-d", "uint8", "-o", panels[-1])
        run("oiiotool", *panels, "--mosaic:pad=8", "3x1", *JPEG, out)


def make_guided(emberline, threads, out):
    """Writes two rows: a room that only the sky lights, through double glazing, without and with guided light samples;
    and a corridor next to a lit room (tests/bench/interiors.py), without and with guided paths. The third picture of a
    row shows the time saved."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        edits = folder / "edits.json"
        edits.write_text('{"emberline_edits": 1, "lights": [{"kind": "material", "name": "bulb", "on": false}]}')
        (folder / "corridor.glb").write_bytes(interiors.corridor().glb())
        room = [HERE / "window_room.glb", "--edits", edits, "--sun", "30,120", "--exposure", "5", "--guiding", "off",
                "--env-sampling"]
        corridor = [folder / "corridor.glb", "--exposure", "4", "--guiding"]
        panels = []
        for scene, ways in ((room, ("light", "guided")), (corridor, ("off", "on"))):
            frames = [folder / f"{way}.exr" for way in ways]
            for way, frame in zip(ways, frames):
                panels.append(frame.with_suffix(".png"))
                run(emberline, "render", *scene, way, "--size", "400x225", "--spp", "64", "--streams", "2", "--aov",
                    "variance,time", "-o", frame, "-o", panels[-1], "--quiet", *threads)
            panels.append(folder / f"saving_{ways[1]}.png")
            run(emberline, "heatmap", frames[1], "--against", frames[0], "-o", panels[-1], "--plain", "--log", "--range",
                "0.3,30", "--colors", "viridis", "--quiet")
        run("oiiotool", *panels, "--mosaic:pad=8", "3x2", *JPEG, out)


def make_denoised(emberline, threads, out):
    """Writes a picture with few samples, the denoised picture, its estimated error, and a picture with many samples."""
    with tempfile.TemporaryDirectory() as folder:
        names = ("few", "denoised", "error", "many")
        few, denoised, error, many = panels = [pathlib.Path(folder) / f"{name}.png" for name in names]
        frame = pathlib.Path(folder) / "frame.exr"
        render = [emberline, "render", HERE / "teapot.glb", "--size", "320x180", "--quiet", *threads]
        run(*render, "-o", few, "--spp", "16", "--streams", "2")
        run(*render, "-o", frame, "-o", denoised, "--spp", "16", "--denoise")
        run(emberline, "heatmap", frame, "-o", error, "--of", "denoised_error", "--colors", "inferno", "--plain", "--quiet")
        run(*render, "-o", many, "--spp", "4096")
        run("oiiotool", *panels, "--mosaic:pad=8", "2x2", *JPEG, out)


def make_layers(emberline, threads, out):
    """Writes the image, its light by kind of path, its albedo, normals, depth and object ids."""
    light = ["direct", "indirect", "reflection", "transmission"]  # the other kinds carry no light in this scene
    with tempfile.TemporaryDirectory() as folder:
        frame = pathlib.Path(folder) / "frame.exr"
        run(emberline, "render", HERE / "glass_metal.glb", "-o", frame, "--size", "320x180", "--spp", "256", "--quiet", "--aov",
            ",".join([*light, "albedo", "N", "Z", "id"]), *threads)
        to_srgb = ["--colorconvert", "linear", "sRGB"]
        panels = {"": to_srgb, **{f"{layer}.": to_srgb for layer in [*light, "albedo"]},
                  "N.": ["--addc", "1", "--mulc", ".5"], "Z": ["--subc", DEPTHS[0], "--divc", DEPTHS[1]],
                  "id": ["--mulc", 2**32 - 1, "--divc", OBJECTS, "--colormap", "turbo"]}  # ids are read / (2^32 - 1)
        names = []
        for layer, change in panels.items():
            names.append(pathlib.Path(folder) / f"{len(names)}.png")
            if layer in ("Z", "id"):
                channels = layer
            else:
                channels = ",".join(f"{as_}={layer}{name}" for as_, name in zip("RGB", "XYZ" if layer == "N." else "RGB"))
            run("oiiotool", frame, "--ch", channels, *change, *(["--ch", "0,0,0"] if layer == "Z" else []), "-d", "uint8", "-o",
                names[-1])
        run("oiiotool", *names, "--mosaic:pad=8", "3x3", *JPEG, out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--emberline", type=pathlib.Path, default=HERE.parent / "build/release/bin/emberline")
    parser.add_argument("--out", type=pathlib.Path, default=HERE / "gallery")
    parser.add_argument("--size", default="800x450", help="size of each half of figure 1")
    parser.add_argument("--threads", default="2")
    parser.add_argument("--only", default="", help="make only these pictures; names have no suffix (default: all)")
    options = parser.parse_args()
    threads = ["--threads", options.threads]
    shared = [*OPTIONS, "--size", options.size, *threads]
    figures = {f"figure_1_{scene}": lambda out, scene=scene: make_figure(options.emberline, scene, [shared], out)
               for scene in SCENES}
    blurs = [BLUR + blur_options + threads for blur_options in (SHUTTER + ["--plain"], LENS + ["--plain"], SHUTTER + LENS)]
    figures["blur"] = lambda out: make_figure(options.emberline, "moving_blade", blurs, out)
    figures["heatmaps"] = lambda out: make_heatmaps(options.emberline, options.threads, out)
    figures["clamped"] = lambda out: make_clamped(options.emberline, threads, out)
    figures["layers"] = lambda out: make_layers(options.emberline, threads, out)
    figures["guided"] = lambda out: make_guided(options.emberline, threads, out)
    figures["denoised"] = lambda out: make_denoised(options.emberline, threads, out)
    for name in options.only.split(",") if options.only else figures:
        out = options.out / f"{name}.jpg"
        figures[name](out)
        print(f"wrote {out}")


if __name__ == "__main__":
    try:
        main()
    except (subprocess.CalledProcessError, FileNotFoundError) as error:
        sys.exit(f"make_heatmaps.py: {error}")
