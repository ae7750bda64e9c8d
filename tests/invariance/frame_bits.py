"""Prints a hash of the pixels for every driver, sampler and estimator of a program, on eight scenes.
Use it on one machine, by hand, for changes that must not change a bit:

  frame_bits.py BEFORE/bin/emberline > before.txt
  frame_bits.py AFTER/bin/emberline --against before.txt

The hash ignores the file's header and the order of its tiles. Exit code 1: some frames differ."""

import argparse
import hashlib
import itertools
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

SCENES = ("checker_plane", "cornell_box", "glass_metal", "mis_plates", "moving_blade", "roughness_spheres",
          "shallow_focus", "thin_wires")
FRAME = "--size 48x36 --spp 16 --threads 2 --quiet --aov variance,albedo,N,Z,id,stop".split()
OTHER_SETTINGS = (  # settings besides driver, sampler and estimator
    "--integrator direct", "--integrator ambient_occlusion", "--integrator normal", "--crop 5,3,31,29",
    "--seed 7", "--spp 21",
    "--transparent", "--max-depth 2", "--filter gaussian", "--bucket-size 7", "--bucket-order spiral",
    "--driver bisection --bisection-axis rows", "--driver bisection --bisection-axis columns",
    "--driver bisection --crop 5,3,31,29", "--driver adaptive --crop 5,3,31,29",
    "--driver adaptive --unbiased", "--driver adaptive --allocation mse",
    "--driver adaptive --allocation relmse", "--driver adaptive --min-spp 4 --max-spp 32",
    "--driver adaptive --streams 2", "--driver bucket --streams 2", "--threads 1 --driver adaptive",
)


def names_of(program, option):
    """Returns the names that a program's help lists below an option. Also reads the help of older programs."""
    for flag in ("--help-all", "--help"):
        run = subprocess.run([program, "render", flag], capture_output=True, text=True)
        if run.returncode == 0:
            break
    found = re.search(rf"\n *{option} NAME.*\n((?: {{6,}}.*\n)+)", run.stdout)
    return re.findall(r"^(?: {8}| {32})([\w-]+): ", found[1], re.MULTILINE)


def settings_of(program):
    samplers, estimators = names_of(program, "--sampler"), names_of(program, "--estimator")
    for driver, sampler in itertools.product(names_of(program, "--driver"), samplers):
        yield f"--driver {driver} --sampler {sampler}"
    for sampler, estimator in itertools.product(samplers, estimators):
        yield f"--driver adaptive --sampler {sampler} --estimator {estimator}"
        yield f"--driver bucket --sampler {sampler} --estimator {estimator} --noise-threshold 0.08"
        yield f"--driver adaptive --sampler {sampler} --estimator {estimator} --noise-threshold 0.08"
    yield from OTHER_SETTINGS


def chunks(data):
    """Returns the stored tiles of an EXR file, sorted."""
    assert struct.unpack_from("<I", data)[0] == 20000630 and data[5] == 2, "not a tiled EXR of one part"
    at, header = 8, {}
    while data[at]:
        name, at = data[at : data.index(0, at)], data.index(0, at) + 1
        at = data.index(0, at) + 1  # skips the type
        size = struct.unpack_from("<i", data, at)[0]
        header[name], at = data[at + 4 : at + 4 + size], at + 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", header[b"dataWindow"])
    width, height = struct.unpack_from("<2I", header[b"tiles"])
    count = ((x1 - x0) // width + 1) * ((y1 - y0) // height + 1)
    offsets = sorted(struct.unpack_from(f"<{count}Q", data, at))
    return sorted(data[a:b] for a, b in zip(offsets, offsets[1:] + [len(data)]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--against", type=pathlib.Path, metavar="FILE", help="what it printed before")
    arguments = parser.parse_args()
    folder = pathlib.Path(__file__).resolve().parents[2] / "scenes"

    with tempfile.TemporaryDirectory() as out:

        def frame(job):
            number, (settings, scene) = job
            path = pathlib.Path(out) / f"{number}.exr"
            command = [arguments.program, "render", folder / f"{scene}.glb", "-o", path, *FRAME, *settings.split()]
            run = subprocess.run(command, capture_output=True, text=True)
            if run.returncode:  # some samplers do not support adaptive sampling
                return f"{'exit ' + str(run.returncode):16}  {scene} {settings}"
            digest = hashlib.sha256(b"".join(chunks(path.read_bytes()))).hexdigest()
            path.unlink()
            return f"{digest[:16]}  {scene} {settings}"

        jobs = enumerate(itertools.product(settings_of(arguments.program), SCENES))
        with ThreadPoolExecutor(2) as pool:
            lines = list(pool.map(frame, jobs))
    if not arguments.against:
        print("\n".join(lines))
        return 0
    before = arguments.against.read_text().splitlines()
    different = sorted(set(lines) ^ set(before), key=lambda line: line[16:])
    print("\n".join(different + [f"{len(lines)} frames, {len(set(lines) - set(before))} differ"]))
    return bool(different)


if __name__ == "__main__":
    sys.exit(main())
