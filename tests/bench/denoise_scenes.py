#!/usr/bin/env python3
"""Prints the gain of denoising by scene and sample count, as a Markdown table.

    tests/bench/denoise_scenes.py build/release/bin SCENE.glb... [--assets DIR NAME...]
        [--counts 8,32,128,512] [--reference 1024] [--size 320x180] [--work DIR]

NAME is a scene below DIR; DIR/views.json has its view. Frames that exist in WORK are not rendered again.
"""
import argparse
import json
import pathlib
import statistics
import subprocess


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--assets", nargs="+", default=[])
    parser.add_argument("--counts", default="8,32,128,512")
    parser.add_argument("--reference", type=int, default=1024)
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("denoise_scenes"))
    return parser.parse_args()


def render_arguments(args):
    """Maps each name to its arguments for `emberline render`."""
    found = {path.stem: [str(path)] for path in args.scenes}
    if args.assets:
        root = pathlib.Path(args.assets[0])
        views = json.loads((root / "views.json").read_text())
        for name in args.assets[1:]:
            file, view = next((f, v) for f, v in views.items() if f"/{name}/" in f)
            place = [",".join(map(str, view[key])) for key in ("look_from", "look_at")]
            command = [str(root / file), "--look-from", place[0], "--look-at", place[1], "--fov-y", str(view["fov_y"])]
            if "env" in view:
                command += ["--env", str(root / view["env"])]
            if "env_strength" in view:
                command += ["--env-strength", str(view["env_strength"])]
            found[f"{name} (assets)" if name in found else name] = command
    return found


def frame(args, name, scene, samples, seed):
    """Renders one frame with both halves, unless it exists."""
    out = args.work / f"{name.split()[0]}.{len(name.split())}.{samples}.{seed}.exr"
    if not out.exists():
        subprocess.run([args.bin / "emberline", "render", *scene, "--size", args.size, "--spp", str(samples),
                        "--seed", str(seed), "--aov", "denoising", "-o", out, "--quiet"], check=True)
    return out


def main():
    args = arguments()
    args.work.mkdir(exist_ok=True)
    counts = [int(n) for n in args.counts.split(",")]
    gains = {n: [] for n in counts}
    print("| scene | samples | relMSE, raw | denoised | gain | trimmed | displayed | FLIP | SSIM | bias, raw "
          "| denoised | estimate : truth | blocks covered | unchanged |")
    print("| --- |" + " ---: |" * 13)
    for name, scene in render_arguments(args).items():
        reference = frame(args, name, scene, args.reference, 21)
        for n in counts:
            command = [args.bin / "denoise_bench", frame(args, name, scene, n, 11), reference]
            r = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            raw, clean = r["raw"], r["clean"]
            gain = {key: raw[key] / clean[key] for key in ("relmse", "relmse_trimmed", "display_mse", "flip")}
            gains[n].append(gain)
            print(f"| {name} | {n} | {raw['relmse']:.3g} | {clean['relmse']:.3g} | {gain['relmse']:.2f} "
                  f"| {gain['relmse_trimmed']:.2f} | {gain['display_mse']:.2f} | {gain['flip']:.2f} "
                  f"| {raw['ssim']:.3f}, {clean['ssim']:.3f} | {100 * raw['bias']:+.1f} % | {100 * clean['bias']:+.1f} % "
                  f"| {r['estimate_clean']:.2f} | {r['blocks']:.2f} | {100 * r['kept']:.0f} % |", flush=True)
    for n in counts:
        median = {key: statistics.median(g[key] for g in gains[n]) for key in gains[n][0]}
        print(f"\n{n} samples, medians: relMSE {median['relmse']:.2f}, trimmed {median['relmse_trimmed']:.2f}, "
              f"displayed {median['display_mse']:.2f}, FLIP {median['flip']:.2f} times less")


if __name__ == "__main__":
    main()
