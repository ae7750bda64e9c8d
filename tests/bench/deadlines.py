#!/usr/bin/env python3
"""Measures whether frames with --time-budget end on time, and what the deadline costs.

For each scene, driver and budget, prints the wall time of rendering over the budget, and the squared displayed error
over that of a frame whose mean number of samples, planned by --spp, is the same. References are two frames, so that
their noise is subtracted; see equal_time.py, whose file of scenes this program reads, too.

  PYTHONPATH=build/release/python tests/bench/deadlines.py scenes.jsonl
"""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import emberline
from equal_time import displayed

DRIVERS = ("bucket", "bisection", "adaptive")


def frame(command, words, folder):
    """Renders with the command. Returns the picture and the seconds of rendering."""
    picture, report = Path(folder, "out.exr"), Path(folder, "report.json")
    subprocess.run([*command, *words, "-o", picture, "--report", report, "-q"], check=True)
    return emberline.read(picture), json.loads(report.read_text())["time"]["render_s"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=Path, help="file of scenes")
    parser.add_argument("--emberline", default="build/release/bin/emberline")
    parser.add_argument("--budgets", default="5,20", help="seconds [5,20]")
    parser.add_argument("--drivers", default=",".join(DRIVERS))
    parser.add_argument("--size", default="640x360", help="size of the frames [640x360]")
    parser.add_argument("--reference-spp", type=int, default=1024, help="samples of each half [1024]; 0: no errors")
    options = parser.parse_args()
    print("| scene | driver | budget | time | samples | error |\n| --- | --- | --- | --- | --- | --- |")
    for line in options.scenes.read_text().splitlines():
        row = json.loads(line)
        path = options.scenes.parent / row["scene"]
        settings = {k: str(options.scenes.parent / v) if k in ("env", "edits") else v
                    for k, v in row.get("settings", {}).items()}
        words = [word for k, v in settings.items() for word in (f"--{k.replace('_', '-')}", str(v))]
        command = [options.emberline, "render", path, "--size", options.size, *words]
        with tempfile.TemporaryDirectory() as folder:
            halves = [displayed(frame(command, ["--spp", str(options.reference_spp),
                                                "--seed", seed], folder)[0])
                      for seed in ("901", "902")] if options.reference_spp else []
            for driver in options.drivers.split(","):
                for budget in options.budgets.split(","):
                    def squared_error(picture):
                        x = displayed(picture)
                        return float(((x - halves[0]) * (x - halves[1])).mean())
                    timed, seconds = frame(command, ["--driver", driver, "--time-budget", budget], folder)
                    samples = float(np.mean(timed["samples"]))
                    ratio = float("nan")
                    if halves:
                        planned, _ = frame(command, ["--driver", driver, "--spp", str(round(samples))], folder)
                        # A frame has whole numbers of samples per pixel; its error is scaled to the same number.
                        scale = float(np.mean(planned["samples"])) / samples
                        ratio = squared_error(timed) / (squared_error(planned) * scale)
                    print(f"| {row['name']} | {driver} | {budget} | {seconds / float(budget):.3f} | {samples:.1f} | "
                          f"{ratio:.2f} |", flush=True)


if __name__ == "__main__":
    main()
