#!/usr/bin/env python3
"""Compares the processor time of rendering with two builds of the command.

    tests/bench/two_builds.py NEW OLD --assets DIR SCENE... [--spp N] [--pairs N] [-o TABLE.md]

SCENE and DIR/views.json are as in race_cycles.py. The two builds render in pairs, in random order. Prints the
mean ratio within pairs with its standard error, and the geometric mean over all scenes.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

from pairs import cost_of, finish


def words_of(view, assets):
    words = ["--env", assets / view["env"], "--fov-y", view["fov_y"]]
    for name in ("look_from", "look_at"):
        words += ["--" + name.replace("_", "-"), ",".join(map(str, view[name]))]
    return words + (["--env-strength", view["env_strength"]] if "env_strength" in view else [])


def seconds(program, scene, words):
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([str(w) for w in (program, "render", scene, *words, "-o", f"{out}/a.exr", "--quiet",
                                         "--report", f"{out}/a.json")], check=True)
        return json.loads(pathlib.Path(f"{out}/a.json").read_text())["time"]["render_cpu_s"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("new", type=pathlib.Path)
    p.add_argument("old", type=pathlib.Path)
    p.add_argument("scenes", nargs="+", metavar="SCENE")
    p.add_argument("--assets", type=pathlib.Path, required=True, metavar="DIR")
    p.add_argument("--size", default="640x360")
    p.add_argument("--spp", default="64")
    p.add_argument("--threads", default="2")
    p.add_argument("--pairs", type=int, default=6)
    p.add_argument("-o", "--output", type=pathlib.Path)
    options = p.parse_args()
    programs = {True: options.new.resolve(), False: options.old.resolve()}
    views = json.loads((options.assets / "views.json").read_text())
    lines = ["| scene | pairs | processor s, old | new against old |", "| --- | --- | --- | --- |"]
    means, errors = [], []
    for name in options.scenes:
        words = words_of(views[name], options.assets)
        words += ["--size", options.size, "--spp", options.spp, "--threads", options.threads]
        time, mean, error = cost_of(options.pairs,
                                    lambda which: seconds(programs[which], options.assets / name, words))
        lines.append(f"| {name} | {options.pairs} | {time:.2f} | {100 * mean:+.2f} % +- {100 * error:.2f} % |")
        means.append(mean)
        errors.append(error)
    n = len(means)
    lines.append(f"| geometric mean | | | {100 * sum(means) / n:+.2f} % +- "
                 f"{100 * math.sqrt(sum(e * e for e in errors)) / n:.2f} % |")
    finish(lines, options.output, None)


if __name__ == "__main__":
    main()
