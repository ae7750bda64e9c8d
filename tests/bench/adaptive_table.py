#!/usr/bin/env python3
"""Makes the table of gains of adaptive sampling by scene (tests/bench/results).

  adaptive_table.py --bench build/release/bin/adaptive_bench [--assets DIR] [--size 192x108]
      [--seeds 2] [--out DIR] [--only NAME,...] [--methods NAME,...] [--print]

Runs adaptive_bench on our scenes, and on FlightHelmet if an assets DIR (with views.json) is given.
Stores figures in the output DIR/NAME.json and references in DIR/NAME.bin, and prints the tables.
"""

import argparse
import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
SCENES = os.path.join(HERE, "..", "..", "scenes")
ESTIMATORS = ["contrast", "painter-sloan", "chi-square", "kajiya", "dammertz"]
DEFAULT = "nested"
OWN = [estimator + "/" + metric for estimator in (DEFAULT, "two-stream")
       for metric in ("mse", "relmse", "display")]
# Samples of each reference. A reference needs more samples than adaptive sampling gives to any pixel.
REFERENCE_SAMPLES = {"flight_helmet": 16384, "thin_wires": 16384}
NAMES = {
    "flight_helmet": "FlightHelmet",
    "cornell_box": "Cornell box",
    "teapot": "teapot",
    "glass_metal": "glass still life",
    "thin_wires": "thin wires",
    "moving_blade": "moving blade",
}


def view_of(assets, scene):
    with open(os.path.join(assets, "views.json")) as file:
        view = json.load(file)[scene]
    words = [os.path.join(assets, scene)]
    for option, key in (("--look-from", "look_from"), ("--look-at", "look_at")):
        words += [option, ",".join(str(x) for x in view[key])]
    words += ["--fov-y", str(view["fov_y"]), "--env", os.path.join(assets, view["env"])]
    return words


def scene_words(name, options):
    width, height = (int(n) for n in options.size.split("x"))
    size = ["--size", options.size]
    if name == "flight_helmet":
        return view_of(options.assets, "scenes/flight_helmet/flight_helmet.gltf") + size
    words = [os.path.join(SCENES, name + ".glb")]
    if name == "moving_blade":
        words += ["--time", "0", "--shutter", "0,0.5"]
    if name == "thin_wires":
        words += ["--env", os.path.join(SCENES, "dusk.hdr")]
    if name == "cornell_box":  # its view is square
        side = round((width * height) ** 0.5)
        size = ["--size", f"{side}x{side}"]
    return words + size


def measure(name, options):
    base = os.path.join(options.out, name)
    command = [options.bench, *scene_words(name, options), "--cache", base + ".bin"]
    command += ["--json", base + ".json", "--seeds", str(options.seeds)]
    command += ["--reference-spp", str(REFERENCE_SAMPLES.get(name, 2048))]
    command += ["--budgets", options.budgets, "--methods", options.methods]
    subprocess.run(command, check=True, stdout=sys.stderr)


def gain_of(name, row, error):
    """Returns the gain along uniform sampling's own curve. Uniform frames of thin_wires hit the rare highlights
    too seldom for a curve, so the error is assumed to fall as 1/N in that scene."""
    figures = row[error]
    if name == "thin_wires":
        return figures["uniform"] / figures["error"] / row["time_ratio"]
    return figures["gain"]


def gains(names, options):
    """Prints the time of uniform sampling to equal error, divided by the time of the method that minimises this
    error."""
    two_streams = set(OWN) <= set(options.methods.split(","))
    heads = [f"{error}: limit | as is | gain" + (" | `two-stream`" if two_streams else "") for error in ("MSE", "relMSE")]
    print("| scene | spp | " + " | ".join(heads) + " |")
    print("| --- | --- |" + " --- |" * (8 if two_streams else 6))
    for name in names:
        figures = load(name, options)
        for budget, rows in figures["methods"].items():
            cells = [NAMES[name], budget]
            for error in ("mse", "relmse"):
                limit = figures["limits"][budget][error]
                gain = gain_of(name, rows[DEFAULT + "/" + error], error)
                cells += [f"{limit['independent']:.2f}", f"{limit['stratified']:.2f}",
                          f"**{gain:.2f}** ({100 * gain / limit['independent']:.0f}, "
                          f"{100 * gain / limit['stratified']:.0f} %)"]
                if two_streams:
                    cells.append(f"{gain_of(name, rows['two-stream/' + error], error):.2f}")
            print("| " + " | ".join(cells) + " |")


def side_by_side(names, options):
    """Compares both estimators in rays, which do not depend on machine load."""
    print("\n| scene | spp | mse: two-stream | nested | relmse: two-stream | nested | bias: two-stream | nested |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name in names:
        for budget, rows in load(name, options)["methods"].items():
            cells = [NAMES[name], budget]
            for error in ("mse", "relmse"):
                cells += [f"{rows[m + '/' + error][error]['ray_gain']:.2f}" for m in ("two-stream", "nested")]
            for row in (rows["two-stream/relmse"], rows["nested/relmse"]):
                cells.append(f"{100 * row['bias']:+.2f} ± {100 * row['bias_se']:.2f}")
            print("| " + " | ".join(cells) + " |")


def estimators(names, options):
    methods = options.methods.split(",")
    budget = options.budgets.split(",")[0]
    print(f"\n{budget} spp on average; gain in mse / in relmse; signed bias of the frame in per cent")
    print("| scene | " + " | ".join(methods) + " |")
    print("| --- |" + " --- |" * len(methods))
    for name in names:
        rows = load(name, options)["methods"][budget]
        cells = []
        for method in methods:
            row = rows[method]
            cells.append(f"{gain_of(name, row, 'mse'):.2f} / {gain_of(name, row, 'relmse'):.2f}; "
                         f"{100 * row['bias']:+.2f} ± {100 * row['bias_se']:.2f}")
        print("| " + " | ".join([NAMES[name]] + cells) + " |")


def calibration(names, options):
    print(f"\n| estimated over true RMS error of the display, {DEFAULT}/display | "
          + " | ".join(options.budgets.split(",")) + " |")
    print("| --- |" + " --- |" * len(options.budgets.split(",")))
    for name in names:
        methods = load(name, options)["methods"]
        cells = [f"{methods[b][DEFAULT + '/display']['calibration']:.2f}"
                 for b in options.budgets.split(",")]
        print("| " + " | ".join([NAMES[name]] + cells) + " |")


def load(name, options):
    with open(os.path.join(options.out, name + ".json")) as file:
        return json.load(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", required=True)
    parser.add_argument("--assets")
    parser.add_argument("--size", default="192x108")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--budgets", default="32,128,512")
    parser.add_argument("--out", default="adaptive_table")
    parser.add_argument("--only", default=",".join(NAMES))
    parser.add_argument("--methods", default=",".join(OWN + ESTIMATORS),
                        help="list that includes the default's own three")
    parser.add_argument("--print", action="store_true", help="print existing figures without measuring")
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    names = [n for n in options.only.split(",") if n != "flight_helmet" or options.assets]
    if not options.print:
        for name in names:
            measure(name, options)
    names = [n for n in names if os.path.exists(os.path.join(options.out, n + ".json"))]
    gains(names, options)
    if set(OWN) <= set(options.methods.split(",")):
        side_by_side(names, options)
    estimators(names, options)
    calibration(names, options)


if __name__ == "__main__":
    main()
