"""Blur is the mean of many instants: renders every animation of a file over a stretch of it, once with the shutter open
and as stills whose mean is taken, and compares the two. By hand (minutes a file):

  blur_of_instants.py build/release/bin/emberline fox.glb milk_truck.gltf ...

Needs `oiiotool`. What is said: the error of the blurred picture against the mean of the stills, and what noise and the
stills' number leave of it, which two means of half the stills each tell. Exit code 1: some differ by more."""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile


def run(*words):
    return subprocess.run([str(w) for w in words], check=True, capture_output=True, text=True).stdout


def mean(pictures, out):
    """Of EXRs, some at a time: a command line holds only so many."""
    sum_of = []
    for i in range(0, len(pictures), 16):
        group = pictures[i : i + 16]
        words = ["oiiotool", group[0], "--ch", "R,G,B"]
        for picture in group[1:]:
            words += [picture, "--ch", "R,G,B", "--add"]
        sum_of.append(out.with_name(f"{out.stem}.{i}.exr"))
        run(*words, "-d", "float", "-o", sum_of[-1])
    words = ["oiiotool", sum_of[0]]
    for picture in sum_of[1:]:
        words += [picture, "--add"]
    run(*words, "--mulc", 1 / len(pictures), "-d", "float", "-o", out)
    return out


def animations(program, scene):
    """Index and duration of each."""
    found = []
    for line in run(program, "info", scene).splitlines():
        words = line.split()
        if words[:1] == ["animation"] and " s, " in line:
            found.append((int(words[1]), float(line.split(" s, ")[0].split()[-1])))
    return found


def compare(program, scene, animation, start, length, options, folder):
    how = ["--animation", animation, "--size", options.size, "--quiet", *options.view.split()]
    # 1 frame a second: the shutter counts in seconds.
    blurred = folder / "blurred.exr"
    run(program, "render", scene, *how, "--time", start, "--fps", 1, "--shutter", f"0,{length}", "--spp", options.spp,
        "-o", blurred)
    stills = []
    for i in range(options.stills):
        stills.append(folder / f"still.{i}.exr")
        time = start + length * (i + 0.5) / options.stills
        run(program, "render", scene, *how, "--time", time, "--seed", i + 1, "--spp",
            max(1, options.spp // options.stills * 4), "-o", stills[-1])
    whole = mean(stills, folder / "mean.exr")
    halves = [mean(stills[i::2], folder / f"half{i}.exr") for i in range(2)]
    error = math.sqrt(json.loads(run(program, "compare", blurred, whole, "--json"))["mse"])
    # Of two halves, each with twice the variance of the whole.
    noise = math.sqrt(json.loads(run(program, "compare", *halves, "--json"))["mse"]) / 2
    return error, noise


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("scenes", type=pathlib.Path, nargs="+")
    parser.add_argument("--stills", type=int, default=256)
    parser.add_argument("--spp", type=int, default=1024)
    parser.add_argument("--size", default="96x72")
    parser.add_argument("--share", type=float, default=0.1, help="of an animation that the shutter is open [0.1]")
    parser.add_argument("--view", default="", help="further options of every picture")
    options = parser.parse_args()
    wrong = 0
    for scene in options.scenes:
        for animation, duration in animations(options.program, scene):
            with tempfile.TemporaryDirectory() as folder:
                error, noise = compare(options.program, scene, animation, duration * 0.4, duration * options.share, options,
                                       pathlib.Path(folder))
            differs = error > 3 * noise
            wrong += differs
            print(f"{scene.name} animation {animation}: RMSE {error:.2e}, of the stills' mean alone {noise:.2e}"
                  f"{'  DIFFERS' if differs else ''}", flush=True)
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
