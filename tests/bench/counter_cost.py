#!/usr/bin/env python3
"""Measures the cost of the report's counters; exits with 1 if it is 1 % of processor time or more.

    tests/bench/counter_cost.py [--build build/uncounted] [--pairs N] [-o TABLE.md]

Builds the command a second time from a copy of the sources that counts neither rays nor the maximum
samples per pixel. Renders with the two builds in pairs on one thread, in random order, and prints the
mean ratio within pairs and its standard error. The limit applies to the mean minus two standard
errors, so noise alone exceeds it at most once in 40 runs.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

from pairs import cost_of, finish

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LIMIT = 0.01
FRAMES = {
    "paths, Cornell box": ["cornell_box.glb", "--spp", "64"],
    "paths, roughness spheres": ["roughness_spheres.glb", "--spp", "64", "--env", str(ROOT / "scenes/studio.hdr")],
    "one ray a sample, Cornell box": ["cornell_box.glb", "--spp", "1024", "--integrator", "depth"],
}
# (file, original text, text that counts nothing)
EDITS = [
    ("renderer/film/film.h",
     "  uint32_t scatter = 0;  // continued paths\n"
     "  uint32_t shadow = 0;   // visibility of sampled lights\n",
     "  struct Nothing {\n"
     "    void operator++(int) {}\n"
     "    operator uint32_t() const { return 0; }\n"
     "  };\n"
     "  Nothing scatter, shadow;\n"),
    ("renderer/drivers/frame.h", "    camera++;\n", ""),
    ("renderer/engine/render_worker.cpp",
     "    counters_.max_samples = std::max(counters_.max_samples, addresses_[i].sample + 1);\n", ""),
]


def run(*command):
    return subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True).stdout


def build(source, tree):
    run("cmake", "-G", "Ninja", "-S", source, "-B", tree, "-DCMAKE_BUILD_TYPE=Release",
        "-DCMAKE_CXX_FLAGS_RELEASE=-O3 -DNDEBUG")
    run("cmake", "--build", tree, "--target", "emberline")
    return tree / "bin/emberline"


def uncounted_sources(folder):
    if folder.exists():
        shutil.rmtree(folder)
    for name in run("git", "-C", ROOT, "ls-files").splitlines():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    for name, old, new in EDITS:
        text = (folder / name).read_text()
        if text.count(old) != 1:
            sys.exit(f"counter_cost.py: {name} must contain this text exactly once: {old}")
        (folder / name).write_text(text.replace(old, new))
    return folder


def seconds(program, words):
    with tempfile.TemporaryDirectory() as out:
        run(program, "render", ROOT / "scenes" / words[0], *words[1:], "-o", f"{out}/a.exr", "--size", "320x180",
            "--threads", "1", "--quiet", "--report", f"{out}/a.json")
        return json.loads(pathlib.Path(f"{out}/a.json").read_text())["time"]["render_cpu_s"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--build", type=pathlib.Path, default=ROOT / "build/uncounted")
    p.add_argument("--pairs", type=int, default=9)
    p.add_argument("-o", "--output", type=pathlib.Path)
    options = p.parse_args()
    folder = options.build.resolve()
    programs = {True: build(ROOT, folder / "with"),
                False: build(uncounted_sources(folder / "source"), folder / "without")}
    lines = ["| frame | processor s | with counters against without |", "| --- | --- | --- |"]
    failed = False
    for name, words in FRAMES.items():
        time, mean, error = cost_of(options.pairs, lambda which, words=words: seconds(programs[which], words))
        lines.append(f"| {name} | {time:.2f} | {100 * mean:+.2f} % +- {100 * error:.2f} % |")
        failed = failed or mean - 2 * error > LIMIT
    finish(lines, options.output, f"counter_cost.py: the counters cost more than {100 * LIMIT:.0f} %" if failed else None)


main()
