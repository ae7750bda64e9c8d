#!/usr/bin/env python3
"""Measures the cost of a feature in a scene that does not use it; exits with 1 if it is 1 % or more.

    tests/bench/unused_features.py WITH WITHOUT [--build build/unused] [--repetitions N] [-o TABLE.md]

WITH and WITHOUT are checkouts after and before the feature; plain_scene_bench is built from each.
Counts the instructions of one frame under Valgrind, which do not depend on machine load, and times
the two programs alternately. The limit applies to the instructions; times are only reported. Both
programs are compiled for x86-64-v3, since Valgrind 3.19 does not support AVX-512. They are compiled
without link-time optimisation, whose inlining depends on the program's size. With
--cmake=-DEMBERLINE_LTO=ON the figures include the effect of that inlining.
"""
import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LIMIT = 0.01
COUNTED_SPP = 16  # one batch of the sampler; a frame takes about 50 times as long under Valgrind


def run(*command):
    return subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True)


def build(checkout, tree, extra):
    run("cmake", "-G", "Ninja", "-S", checkout, "-B", tree, "-DCMAKE_BUILD_TYPE=Release",
        "-DCMAKE_CXX_FLAGS_RELEASE=-O3 -DNDEBUG", "-DEMBERLINE_NATIVE=OFF",
        "-DEMBERLINE_LTO=OFF", *extra)
    run("cmake", "--build", tree, "--target", "plain_scene_bench")
    return tree / "bin/plain_scene_bench"


def count(program):
    """Returns the instructions of the frame, and its figures."""
    with tempfile.TemporaryDirectory() as folder:
        done = run("valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out",
                   "--toggle-collect=emberline_measured_frame", program, COUNTED_SPP)
    instructions = int(re.search(r"Collected : (\d+)", done.stderr).group(1))
    return instructions, json.loads(done.stdout)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkouts", nargs=2, type=pathlib.Path, metavar="CHECKOUT", help="with the feature, and without it")
    p.add_argument("--build", type=pathlib.Path, default=ROOT / "build/unused")
    p.add_argument("--repetitions", type=int, default=11)
    p.add_argument("--spp", type=int, default=256, help="samples per pixel of the timed frames")
    p.add_argument("--cmake", action="append", default=[], metavar="-DNAME=VALUE", help="CMake option of both builds")
    p.add_argument("-o", "--output", type=pathlib.Path)
    options = p.parse_args()
    programs = [build(checkout.resolve(), options.build.resolve() / name, options.cmake)
                for checkout, name in zip(options.checkouts, ("with", "without"))]
    (with_count, with_frame), (without_count, without_frame) = (count(program) for program in programs)
    if with_frame["rays"] != without_frame["rays"]:
        sys.exit(f"unused_features.py: the builds traced different numbers of rays: {with_frame}, {without_frame}")
    times = [[json.loads(run(program, options.spp).stdout)["cpu_s"] for program in programs]
             for _ in range(options.repetitions)]
    ratios = [a / b - 1 for a, b in times]
    more = with_count / without_count - 1
    text = "\n".join([
        "| | with it | without it | difference |",
        "| --- | --- | --- | --- |",
        f"| million instructions, {with_frame['samples']} samples | {with_count / 1e6:.1f} | "
        f"{without_count / 1e6:.1f} | {100 * more:+.2f} % |",
        f"| processor s, {options.spp} spp, median of {len(times)} | {statistics.median(t[0] for t in times):.3f} | "
        f"{statistics.median(t[1] for t in times):.3f} | {100 * statistics.median(ratios):+.2f} % "
        f"({100 * min(ratios):+.1f} to {100 * max(ratios):+.1f}) |", ""])
    print(text)
    if options.output:
        options.output.write_text(text)
    if more > LIMIT:
        sys.exit(f"unused_features.py: unused features cost {100 * more:.2f} % instructions, above {100 * LIMIT:.0f} %")


main()
