#!/usr/bin/env python3
"""Measures the cost of `--display tev://...` for a render; exits with 1 if it is 2 % or more.

    tests/bench/viewer_cost.py [--emberline PROGRAM] [--pairs N] [--only WORD] [-o TABLE.md]

Renders with and without a viewer in pairs, in random order. The viewer is another process, which
discards its input. On one thread, the render's processor time includes all costs: the pauses of
progressive drivers (which would also stall other threads), the sending thread, and system time. Prints
the mean ratio within pairs with its standard error. The limit applies to the mean minus two standard
errors, so noise alone exceeds it at most once in 40 runs.
"""
import argparse
import json
import multiprocessing
import pathlib
import socket
import subprocess
import sys
import tempfile

from pairs import cost_of, finish

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LIMIT = 0.02
PATHS = ["teapot.glb", "--spp", "8"]
ONE_RAY = ["cornell_box.glb", "--spp", "32", "--integrator", "depth"]
FRAMES = {
    "bucket, paths, teapot": PATHS,
    "bucket, one ray a sample, Cornell box": ONE_RAY,
    "bisection, paths, teapot": PATHS + ["--driver", "bisection"],
    "bisection, one ray a sample, Cornell box": ONE_RAY + ["--driver", "bisection"],
    "adaptive, paths, teapot": PATHS + ["--driver", "adaptive"],
}


def discard_input(listener, received):
    while True:
        connection, _ = listener.accept()
        with connection:
            while chunk := connection.recv(1 << 20):
                received.value += len(chunk)


def cpu_seconds(program, words, url):
    with tempfile.TemporaryDirectory() as out:
        viewer = ["--display", url] if url else []
        subprocess.run([program, "render", ROOT / "scenes" / words[0], *words[1:], "-o", f"{out}/a.exr",
                        "--size", "640x360", "--threads", "1", "--report", f"{out}/a.json", *viewer],
                       check=True, capture_output=True)
        report = json.loads(pathlib.Path(f"{out}/a.json").read_text())
        if report["warnings"]:
            sys.exit(f"viewer_cost.py: {report['warnings']}")
        return report["time"]["render_cpu_s"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--emberline", type=pathlib.Path, default=ROOT / "build/release/bin/emberline")
    p.add_argument("--pairs", type=int, default=9)
    p.add_argument("--only", default="", help="run only frames whose names contain this")
    p.add_argument("-o", "--output", type=pathlib.Path)
    options = p.parse_args()
    listener = socket.create_server(("127.0.0.1", 0))
    url = "tev://127.0.0.1:%d" % listener.getsockname()[1]
    received = multiprocessing.Value("Q", 0)
    multiprocessing.Process(target=discard_input, args=(listener, received), daemon=True).start()
    picture = 640 * 360 * 16
    lines = ["| frame | processor s | pictures sent | with a viewer against without |", "| --- | --- | --- | --- |"]
    failed = False
    for name, words in FRAMES.items():
        if options.only not in name:
            continue
        before = received.value
        time, mean, error = cost_of(
            options.pairs,
            lambda which, words=words: cpu_seconds(options.emberline, words, url if which else None))
        pictures = (received.value - before) / options.pairs / picture
        lines.append(f"| {name} | {time:.2f} | {pictures:.1f} | "
                     f"{100 * mean:+.2f} % +- {100 * error:.2f} % |")
        failed = failed or mean - 2 * error > LIMIT
    finish(lines, options.output, f"viewer_cost.py: a viewer costs more than {100 * LIMIT:.0f} %" if failed else None)


main()
