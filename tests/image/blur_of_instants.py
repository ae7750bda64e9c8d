"""Checks that motion blur is the mean of many instants. Renders every animation of a file over a part of its duration,
once with an open shutter and once as stills, and compares the blurred picture with the mean of the stills. Run by hand
(minutes per file):

  blur_of_instants.py build/release/bin/emberline fox.glb milk_truck.gltf ...

Needs `oiiotool`. Prints the RMS difference between the two pictures, the part of the difference that noise and the
number of stills explain, and the remainder. The exit code is 1 if some pictures differ by more than noise.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

SEEDS = 16  # seeds of the stills; stills of one seed share a command
GROUP = 64  # pictures per command line
MAX_RATIO = 1.3  # times the noise; a few thousand pixels determine the noise to a few per cent


def run(*words):
    return subprocess.run([str(w) for w in words], check=True, capture_output=True, text=True).stdout


def mean(pictures, out):
    """Writes the mean of the EXRs to `out`. Adds them up in groups, because the length of a command line is limited."""
    sums = []
    for i in range(0, len(pictures), GROUP):
        words = ["oiiotool", pictures[i], "--ch", "R,G,B"]
        for picture in pictures[i + 1 : i + GROUP]:
            words += [picture, "--ch", "R,G,B", "--add"]
        sums.append(out.with_name(f"{out.stem}.{i}.exr"))
        run(*words, "-d", "float", "-o", sums[-1])
    adds = [word for picture in sums[1:] for word in (picture, "--add")]
    run("oiiotool", sums[0], *adds, "--mulc", 1 / len(pictures), "-d", "float", "-o", out)
    return out


def animations(program, scene):
    """Returns the index and the duration of each animation."""
    found = []
    for line in run(program, "info", scene).splitlines():
        words = line.split()
        if words[:1] == ["animation"] and " s, " in line:
            found.append((int(words[1]), float(line.split(" s, ")[0].split()[-1])))
    return found


def rms_difference(program, a, b):
    return math.sqrt(json.loads(run(program, "compare", a, b, "--json"))["mse"])


def compare(program, scene, animation, duration, options, folder):
    """Returns the RMS difference between blur and stills, and the noise of both. The noise is estimated from halves
    with different seeds."""
    how = ["--animation", animation, "--size", options.size, "--quiet", *options.view.split()]
    # At `fps` frames a second the stills are one frame apart. The shutter opens half a frame before the first still and
    # closes half a frame after the last.
    fps = options.stills / (duration * options.share)
    first = round(0.4 * duration * fps)
    seeds = min(SEEDS, options.stills)
    for k in range(2):
        run(program, "render", scene, *how, "--frame", first, "--fps", fps,
            "--shutter", f"-0.5,{options.stills - 0.5}", "--spp", options.spp // 2, "--seed", k,
            "-o", folder / f"blurred{k}.exr")
    for k in range(seeds):
        frames = f"{first + k}-{first + options.stills - 1}x{seeds}"
        run(program, "render", scene, *how, "--frames", frames, "--fps", fps,
            "--spp", options.still_spp, "--seed", k + 2, "-o", folder / "still.#.exr")
    stills = [folder / f"still.{first + i}.exr" for i in range(options.stills)]
    halves = [mean(stills[k::2], folder / f"stills{k}.exr") for k in range(2)]
    blurs = [folder / f"blurred{k}.exr" for k in range(2)]
    # The mean of two halves has half the standard deviation of their difference.
    noise = math.hypot(*(rms_difference(program, *pair) / 2 for pair in (halves, blurs)))
    return rms_difference(program, mean(blurs, folder / "blur.exr"), mean(halves, folder / "stills.exr")), noise


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("scenes", type=pathlib.Path, nargs="+")
    parser.add_argument("--stills", type=int, default=256)
    parser.add_argument("--spp", type=int, default=4096, help="of the blurred picture [4096]")
    parser.add_argument("--still-spp", type=int, default=64, help="of each still [64]")
    parser.add_argument("--size", default="48x36")
    parser.add_argument("--share", type=float, default=0.1, help="of an animation that the shutter is open [0.1]")
    parser.add_argument("--view", default="", help="further options of every picture")
    options = parser.parse_args()
    wrong = 0
    for scene in options.scenes:
        for animation, duration in animations(options.program, scene):
            with tempfile.TemporaryDirectory() as folder:
                error, noise = compare(options.program, scene, animation, duration, options, pathlib.Path(folder))
            differs = error > MAX_RATIO * noise
            wrong += differs
            left = math.sqrt(max(0, error**2 - noise**2))
            print(f"{scene.name} animation {animation}: RMS difference {error:.2e}, of noise {noise:.2e}, "
                  f"left {left:.1e}{'  DIFFERS' if differs else ''}", flush=True)
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
