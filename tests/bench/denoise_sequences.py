#!/usr/bin/env python3
"""Prints what `emberline denoise --across` gains over the same frames denoised alone, as a Markdown table.

    PYTHONPATH=build/release/python tests/bench/denoise_sequences.py build/release/bin --assets DIR
        [NAME...] [--frames 8] [--counts 16,64] [--reference 256] [--size 320x180] [--across 2] [--work DIR]

Renders the first frames of each sequence and measures all but the first two and the last two. The reference has two
halves of independent samples. A squared error is the mean product of the errors against either half, so the reference's
own noise adds nothing to it. The worst 0.1 % of the pixels are left out. Frames that exist in WORK are not rendered
again.
"""
import argparse
import os
import pathlib
import statistics
import subprocess

import emberline
import numpy

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
# The arguments of `emberline render` for frame N, and whether the sequence served to choose the constants of
# renderer/reconstruction/accumulate.cpp.
HELMET_VIEW = ["--look-from", "0.49654,0.53522,1.49109", "--look-at", "-0.02035,0.358,0.01425", "--fov-y", "30"]
HOTEL_VIEW = ["--look-from", "7600,1500,-6300", "--look-at", "12400,800,-9300", "--fov-y", "62", "--env-strength", "8",
              "--turntable-center", "look-at"]
TEAPOT = [SCENES / "teapot.glb", "--env", SCENES / "studio.hdr"]


def sequences(assets):
    scenes, env = assets / "scenes", assets / "env"
    return {
        "blade": (True, lambda n: [SCENES / "moving_blade.glb", "--animation", "blades", "--fps", "96", "--frame", n]),
        "helmet": (True, lambda n: [scenes / "flight_helmet/flight_helmet.gltf", "--env", env / "studio_small_05_1k.hdr",
                                    *HELMET_VIEW, "--turntable", f"{n}/120"]),
        "hotel outside": (True, lambda n: [scenes / "hotel_room/hotel_room.glb", "--turntable", f"{n}/720"]),
        "hotel inside": (False, lambda n: [scenes / "hotel_room/hotel_room.glb", "--env", env / "kloppenheim_05_1k.hdr",
                                           *HOTEL_VIEW, "--turntable", f"{n}/360"]),
        "fox": (False, lambda n: [scenes / "fox_skinned/fox_skinned.glb", "--animation", "Run", "--fps", "24",
                                  "--env", env / "kloppenheim_05_1k.hdr", "--frame", n]),
        "cornell": (False, lambda n: [SCENES / "cornell_box.glb", "--turntable", f"{n}/360"]),
        "teapot": (False, lambda n: [*TEAPOT, "--turntable", f"{n}/240"]),
        "light turns": (True, lambda n: [*TEAPOT, "--env-rotation", 8 * n, "--frame", n]),
        "light drops": (False, lambda n: [*TEAPOT, "--env-strength", 1 if n < 5 else 0.4, "--frame", n]),
    }


def run(command):
    subprocess.run([str(word) for word in command], check=True)


class Frame:
    def __init__(self, path):
        picture = emberline.read(str(path))
        self.planes = dict(zip(picture.channels, numpy.moveaxis(numpy.asarray(picture.pixels), -1, 0)))

    def colour(self, layer):
        return numpy.stack([self.planes[layer + c] for c in "RGB"], -1).astype(float)


def trimmed(errors):
    errors = errors.ravel()
    kept = numpy.argsort(numpy.abs(errors))[: errors.size - errors.size // 1000]
    return errors[kept].mean()


def displayed(linear):
    x = numpy.clip(linear, 0, 1)
    return numpy.where(x < 0.0031308, 12.92 * x, 1.055 * numpy.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


class Measured:
    """The errors of the denoised frames of one sequence, given by the paths of the pictures."""

    def __init__(self, frames, references, motion):
        self.errors, self.estimates, self.flicker = [], [], []
        before = None
        for frame, reference, moving in (map(Frame, paths) for paths in zip(frames, references, motion)):
            picture, halves = frame.colour("denoised."), [reference.colour("half1."), reference.colour("half2.")]
            mean = (halves[0] + halves[1]) / 2
            scale = numpy.sqrt(mean**2 + 0.01 * mean.mean() ** 2)
            now = [(picture - half) / scale for half in halves]
            self.errors.append(trimmed((now[0] * now[1]).mean(-1)))
            truth = numpy.prod([displayed(picture) - displayed(half) for half in halves], 0).mean()
            self.estimates.append(numpy.sqrt((frame.planes["denoised.error"].astype(float) ** 2).mean() / truth))
            velocity = [moving.planes["velocity.X"], -moving.planes["velocity.Y"]]
            if before is not None:
                self.flicker.append(self.change(before, now))
            before = now, velocity
        self.error, self.flicker = statistics.mean(self.errors), statistics.mean(self.flicker)

    @staticmethod
    def change(before, now):
        old, (right, down) = before
        height, width = right.shape
        y, x = numpy.mgrid[0:height, 0:width]
        x, y = numpy.rint(x + right).astype(int), numpy.rint(y + down).astype(int)
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = x[inside], y[inside]
        return trimmed(numpy.prod([new[y, x] - past[inside] for new, past in zip(now, old)], 0).mean(-1))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--assets", type=pathlib.Path, required=True)
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--counts", default="16,64")
    parser.add_argument("--reference", type=int, default=256)
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--across", type=int, default=2)
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("denoise_sequences"))
    args = parser.parse_args()
    measured = range(3, args.frames - 1)
    emberline_command = args.bin / "emberline"

    def render(name, command, samples, seed, frames):
        paths = []
        for n in frames:
            paths.append(args.work / f"{name.replace(' ', '_')}.{samples}.{n:04}.exr")
            if not paths[-1].exists():
                run([emberline_command, "render", *command(n), "--size", args.size, "--spp", samples, "--seed", seed,
                     "--aov", "denoising,velocity", "-o", paths[-1], "--quiet"])
        return paths

    def denoise(name, samples, across):
        stem = name.replace(" ", "_")
        start = os.times()
        run([emberline_command, "denoise", args.work / f"{stem}.{samples}.####.exr", "--across", across, "--quiet",
             "-o", args.work / f"{stem}.{samples}.across{across}.####.exr"])
        end = os.times()
        seconds = end.children_user + end.children_system - start.children_user - start.children_system
        return [args.work / f"{stem}.{samples}.across{across}.{n:04}.exr" for n in measured], seconds

    args.work.mkdir(exist_ok=True)
    gains = {}
    print("| sequence | samples | relMSE, alone | across | times less | worst frame | flicker, times less "
          "| estimate : truth | processor time |")
    print("| --- |" + " ---: |" * 8)
    for name, (tuned, command) in sequences(args.assets).items():
        if args.names and name not in args.names:
            continue
        references = render(name, command, args.reference, 77, measured)
        for samples in map(int, args.counts.split(",")):
            motion = render(name, command, samples, 0, range(1, args.frames + 1))[measured[0] - 1:]
            results, seconds = zip(*(denoise(name, samples, across) for across in (0, args.across)))
            alone, across = (Measured(frames, references, motion) for frames in results)
            gain = alone.error / across.error, alone.flicker / across.flicker
            gains.setdefault(samples, []).append(gain)
            worst = min(a / b for a, b in zip(alone.errors, across.errors))
            print(f"| {name}{' (tuned)' if tuned else ''} | {samples} | {alone.error:.3g} | {across.error:.3g} "
                  f"| {gain[0]:.2f} | {worst:.2f} | {gain[1]:.2f} "
                  f"| {min(across.estimates):.2f} to {max(across.estimates):.2f} | {seconds[1] / seconds[0]:.2f} |",
                  flush=True)
    for samples, found in gains.items():
        print(f"\n{samples} samples, medians: relMSE {statistics.median(g[0] for g in found):.2f}, "
              f"flicker {statistics.median(g[1] for g in found):.2f} times less")


if __name__ == "__main__":
    main()
