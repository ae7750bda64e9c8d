#!/usr/bin/env python3
"""Measures a frame, its parts and the race with Cycles, and writes a page. Run it on a quiet machine.

    tests/bench/measure.py --assets DIR [SCENE...] [--only frame,parts,race] [-o build/figures.md]

DIR and SCENE are as in race_cycles.py (default: the Flight Helmet and the Cornell box). Takes about
half an hour on two cores, most of it for the race's references. If the page exists, sections that are
not measured stay unchanged.
"""
import argparse
import json
import os
import pathlib
import platform
import re
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FIGURES = ROOT / "build/figures.md"
SCENES = ["scenes/flight_helmet/flight_helmet.gltf", "scenes/cornell_box/cornell_box.glb"]


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"measure.py: {command[0]} failed:\n{done.stderr}")
    return done.stdout


def view_options(options, scene):
    v = json.loads((options.assets / "views.json").read_text())[scene]
    words = [f"--{key.replace('_', '-')}=" + ",".join(map(str, v[key])) for key in ("look_from", "look_at")]
    words.append(f"--fov-y={v['fov_y']}")
    if v.get("env"):
        words += ["--env", options.assets / v["env"], f"--env-strength={v.get('env_strength', 1)}"]
    return words


def frame(options):
    for scene in options.scenes:
        text = run(ROOT / "build/release/bin/frame_bench", options.assets / scene, *view_options(options, scene))
        yield f"`frame_bench {scene}` with its view:\n\n```\n{text.strip()}\n```\n"


def parts(options):
    out = json.loads(run(ROOT / "build/release/bin/parts_bench", "--benchmark_format=json",
                         "--benchmark_min_time=0.2"))
    yield "`parts_bench`, nanoseconds per item:\n\n| part | ns |\n| --- | --- |"
    for b in out["benchmarks"]:
        yield f"| {b['name']} | {b['each'] * 1e9:.1f} |"


def race(options):
    with tempfile.NamedTemporaryFile(suffix=".md") as table:
        run(HERE / "race_cycles.py", "--assets", options.assets, *options.scenes, "-o", table.name)
        yield re.sub(r"^Measured .*\n\n", "", pathlib.Path(table.name).read_text())


SECTIONS = {"frame": ("A frame, and Embree's share of it", frame), "race": ("Against Cycles", race),
            "parts": ("Parts", parts)}


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return platform.machine()


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE")
    p.add_argument("--assets", type=pathlib.Path, required=True)
    p.add_argument("--only", default=",".join(SECTIONS))
    p.add_argument("-o", "--output", type=pathlib.Path, default=FIGURES, metavar="PAGE.md")
    options = p.parse_args()
    run("cmake", "--build", ROOT / "build/release", "--target", "emberline", "frame_benches", "parts_bench")
    selected = options.only.split(",")
    page = options.output
    old = dict(re.findall(r"^## (.*?)\n\n(.*?)(?=^## |\Z)", page.read_text(), re.M | re.S)) if page.exists() else {}
    text = "# Figures\n\nWritten by `tests/bench/measure.py`; tests/bench/README.md says what each figure means.\n\n"
    for key, (title, measure) in SECTIONS.items():
        body = old.get(title, "not measured yet\n")
        if key in selected:
            load = os.getloadavg()[0]
            body = (f"{time.strftime('%Y-%m-%d')}, {processor()}, {os.cpu_count()} processors, load average "
                    f"{load:.1f} before.\n\n" + "\n".join(measure(options)) + "\n")
        text += f"## {title}\n\n{body.strip()}\n\n"
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text(text)


main()
