#!/usr/bin/env python3
"""Races Emberline against Blender's Cycles: same scene, view, light, samples, bounces and threads.

    tests/bench/race_cycles.py --assets DIR [SCENE...] [-o race.md] [--chart race.svg]

SCENE is a glTF file below DIR; the default is all below DIR/scenes. Scenes that Blender cannot read
are listed and skipped. DIR/views.json has each scene's view and environment:
    {"SCENE": {"look_from": [x, y, z], "look_at": [x, y, z], "fov_y": degrees, "env": "FILE below DIR"}}

Speed: the renderers run alternately, and ratios are taken within pairs, so that other load affects both.
Error: each renderer renders images of --error-spp samples with several seeds. They are compared with a
reference of --reference-spp samples by the same renderer, which is kept in --cache. With --adaptive-spp
both renderers also sample adaptively: Emberline with that many samples on average, Cycles with at most
four times as many until its default noise threshold of .01. Then error x processor time is compared,
since error falls as 1 / time. Needs Blender (Debian: blender, python3-numpy).
"""
import argparse
import hashlib
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

from growth_plot import COLORS, GRID, INK, line, text

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def parse_arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a = p.add_argument
    a("scenes", nargs="*", metavar="SCENE")
    a("--assets", type=pathlib.Path, required=True)
    a("--emberline", default=ROOT / "build/release/bin/emberline")
    a("--blender", default="blender")
    a("--pairs", type=int, default=5)
    a("--size", default="640x360")
    a("--spp", type=int, default=64)
    a("--threads", type=int, default=2)
    a("--bounces", type=int, default=8, help="bounces after the first surface; --max-depth is one more")
    a("--error-size", default="320x180")
    a("--error-spp", type=int, default=64)
    a("--error-seeds", type=int, default=3, help="0 measures no errors")
    a("--adaptive-spp", type=int, default=0, help="0 races no adaptive sampling")
    a("--reference-spp", type=int, default=4096, help="at 64 times --error-spp, the reference adds 1.6 %% to an error")
    a("--cache", type=pathlib.Path, default=ROOT / "build/race", help="folder for references and compared images")
    a("-o", "--output", type=pathlib.Path, help="the tables as Markdown (default: stdout)")
    a("--json", type=pathlib.Path, help="every run's figures; scenes in this file are not raced again")
    a("--chart", type=pathlib.Path, help="the ratios of all scenes as a picture (SVG)")
    return p.parse_args()


class Unreadable(Exception):
    """Raised if Blender cannot read the scene, or can read only a part of it."""


class Renderer:
    """One of the two renderers: render(...) writes an EXR and returns its figures in seconds and bytes."""

    def __init__(self, options, view):
        self.o, self.view = options, view
        self.env = str((options.assets / view["env"]).resolve()) if view.get("env") else None

    def file(self, suffix):
        self.o.cache.mkdir(parents=True, exist_ok=True)
        return self.o.cache / f"{self.name.lower()}{suffix}"

    def reference(self, scene):
        """Renders the reference, with another seed, unless it exists. Its name has a hash of all that it depends on."""
        o = self.o
        key = json.dumps([str(scene), self.view, o.error_size, o.reference_spp, o.bounces])
        path = self.file("-" + hashlib.sha256(key.encode()).hexdigest()[:12] + ".exr")
        if not path.exists():
            partial = path.with_suffix(".part.exr")
            self.render(scene, o.error_size, o.reference_spp, 1000, partial)
            partial.rename(path)
        return path


class Emberline(Renderer):
    name = "Emberline"

    def render(self, scene, size, spp, seed, output, adaptive=False):
        v, report = self.view, self.file("-report.json")
        triple = lambda x: ",".join(map(str, x))
        command = [str(self.o.emberline), "render", str(scene), "-o", str(output), "--report", str(report),
                   "--size", size, "--spp", str(spp), "--seed", str(seed), "--threads", str(self.o.threads),
                   "--max-depth", str(self.o.bounces + 1), "--filter", "box", "--quiet",
                   "--look-from=" + triple(v["look_from"]), "--look-at=" + triple(v["look_at"]),
                   "--fov-y", str(v["fov_y"])]
        if adaptive:
            command += ["--driver", "adaptive"]
        if self.env:
            command += ["--env", self.env, "--env-strength", str(v.get("env_strength", 1))]
        subprocess.run(command, check=True)
        r = json.loads(report.read_text())
        t = r["time"]
        return {"render_cpu_s": t["render_cpu_s"],
                "samples_per_cpu_s": r["samples"]["total"] / t["render_cpu_s"],
                "samples_per_s": r["samples"]["total"] / t["render_s"],
                "ready_s": t["first_sample_s"], "ready_cpu_s": t["first_sample_cpu_s"],
                "prepare_s": t["load_s"] + t["build_s"],
                "peak_rss_bytes": r["memory"]["peak_rss_bytes"],
                "version": "Emberline " + r["versions"]["emberline"]}


class Cycles(Renderer):
    name = "Cycles"

    def render(self, scene, size, spp, seed, output, adaptive=False):
        width, height = map(int, size.split("x"))
        result, settings = self.file("-result.json"), self.file("-settings.json")
        settings.write_text(json.dumps({
            **self.view, "gltf": str(scene), "env": self.env, "width": width, "height": height,
            "spp": 4 * spp if adaptive else spp, "adaptive": adaptive, "seed": seed, "bounces": self.o.bounces, "threads": self.o.threads, "output": str(output),
            "result": str(result), "log": str(self.file(".log"))}))
        result.unlink(missing_ok=True)
        # Blender's Python searches PATH for its library, and would find that of a pyenv.
        plain = {**os.environ, "PATH": "/usr/local/bin:/usr/bin:/bin"}
        subprocess.run([shutil.which(self.o.blender) or self.o.blender, "-b", "--factory-startup", "-t", str(self.o.threads), "--python",
                        str(HERE / "cycles_scene.py"), "--", str(settings)],
                       check=True, stdout=subprocess.DEVNULL, env=plain)
        r = json.loads(result.read_text())
        if "unreadable" in r:
            raise Unreadable(r["unreadable"])
        if r["unreadable_images"]:
            raise Unreadable("images: " + ", ".join(r["unreadable_images"]))
        samples = width * height * spp  # not true for an adaptive frame
        render_cpu_s = r["done_cpu_s"] - r["first_sample_cpu_s"]
        return {"render_cpu_s": render_cpu_s, "samples_per_cpu_s": samples / render_cpu_s,
                "samples_per_s": samples / (r["done_s"] - r["first_sample_s"]),
                "ready_s": r["first_sample_s"], "ready_cpu_s": r["first_sample_cpu_s"],
                "prepare_s": r["first_sample_s"] - r["ready_s"],
                "peak_rss_bytes": r["peak_rss_bytes"], "version": "Blender " + r["blender"]}


def errors(options, renderer, scene, adaptive=False):
    reference = renderer.reference(scene)
    image = renderer.file("-image.exr")
    found = []
    for seed in range(1, options.error_seeds + 1):
        spp = options.adaptive_spp if adaptive else options.error_spp
        cpu_s = renderer.render(scene, options.error_size, spp, seed, image, adaptive)["render_cpu_s"]
        compared = subprocess.run([str(options.emberline), "compare", str(image), str(reference), "--json"],
                                  check=True, capture_output=True, text=True)
        figures = json.loads(compared.stdout)
        found.append({"relmse": figures["relmse"], "relmse_trimmed": figures["relmse_trimmed"]})
        if adaptive:
            found[-1] = {"cpu_s": cpu_s, **{key: value * cpu_s for key, value in found[-1].items()}}
    return found


# key, label, factor of the unit, digits, whether more is better
ROWS = [
    ("samples_per_cpu_s", "million samples per processor second", 1e-6, 2, True),
    ("samples_per_s", "million samples per second", 1e-6, 2, True),
    ("ready_s", "process start to first sample, s", 1, 2, False),
    ("ready_cpu_s", "the same, processor s", 1, 2, False),
    ("prepare_s", "of that, load and build / synchronize, s", 1, 2, False),
    ("peak_rss_bytes", "peak memory, MiB", 1 / 2**20, 0, False),
    ("relmse", "relMSE at equal samples, x 1000", 1000, 3, False),
    ("relmse_trimmed", "the same without the worst 0.1 %, x 1000", 1000, 3, False),
]


def spread(values, factor=1.0, digits=2):
    values = [v * factor for v in values]
    text = [f"{x:.{digits}f}" for x in (statistics.median(values), min(values), max(values))]
    return f"{text[0]} ({text[1]}–{text[2]})"


def table(options, name, runs, error_runs, adaptive_runs, loads):
    versions = [runs[side][0]["version"] for side in ("ours", "theirs")]
    lines = [f"### {name}", "",
             f"{options.size}, {options.spp} spp, {options.bounces} bounces, {options.threads} threads, "
             f"{options.pairs} pairs; error at {options.error_size}, {options.error_spp} spp, "
             f"{options.error_seeds} seeds. Load average {min(loads):.1f} to {max(loads):.1f}. "
             "Medians (least–most); ratios are taken within pairs, above 1 where Emberline is better.", "",
             f"| | {versions[0]} | {versions[1]} | ratio |", "| --- | --- | --- | --- |"]
    for key, label, factor, digits, more in ROWS:
        both = [[r[key] for r in source[side] if key in r] for source in (runs, error_runs)
                for side in ("ours", "theirs")]
        both = [values for values in both if values]
        if len(both) != 2:
            continue
        ratios = [(a / b if more else b / a) for a, b in zip(*both)]
        lines.append(f"| {label} | {spread(both[0], factor, digits)} | {spread(both[1], factor, digits)} | "
                     f"{spread(ratios)} |")
    figures = ratios_of(runs, error_runs, adaptive_runs)
    for key, label in (("time_trimmed", "(trimmed) error"), ("time", "error"),
                       ("adaptive_trimmed", "(trimmed) error, both adaptive"), ("adaptive", "error, both adaptive")):
        if key in figures:
            lines.append(f"| processor time to equal {label} | | | {figures[key]:.2f} |")
    return "\n".join(lines) + "\n"


def ratios_of(runs, error_runs, adaptive_runs):
    """Returns the ratios between Cycles and Emberline, above 1 if Emberline is better. Ratios of errors are ratios of
    their means."""
    figures = {"speed": statistics.median(a["samples_per_cpu_s"] / b["samples_per_cpu_s"]
                                          for a, b in zip(runs["ours"], runs["theirs"]))}
    for key, suffix in (("relmse_trimmed", "_trimmed"), ("relmse", "")):
        if error_runs["ours"]:
            ours, theirs = (statistics.mean(e[key] for e in error_runs[side]) for side in ("ours", "theirs"))
            figures["error" + suffix] = theirs / ours
            # Error falls as 1 / samples, so time to equal error is (error) x (time per sample).
            figures["time" + suffix] = figures["speed"] * theirs / ours
        if adaptive_runs["ours"]:
            ours, theirs = (statistics.mean(e[key] for e in adaptive_runs[side]) for side in ("ours", "theirs"))
            figures["adaptive" + suffix] = theirs / ours
    return figures


# key, heading, required minimum for each scene, and for the median
SUMMARY = [
    ("speed", "samples per processor second", 2.5, 3),
    ("error_trimmed", "error at equal samples, without the worst 0.1 %", 1, 1 / 0.7),
    ("time_trimmed", "processor time to equal error, without the worst 0.1 %", 3, 5),
    ("time", "the same, all pixels", 1.5, 3),
    ("adaptive_trimmed", "both adaptive, without the worst 0.1 %", 4, 8),
    ("adaptive", "the same, all pixels", 4, 8),
]


def short(name):
    return pathlib.PurePath(name).stem


def summary(figures, unreadable_scenes):
    shown = [row for row in SUMMARY if all(row[0] in f for f in figures.values())]
    row = lambda name, values: f"| {name} | " + " | ".join(values) + " |"
    lines = ["Cycles over Emberline, above 1 where Emberline is better:", "",
             row("scene", [heading for _, heading, _, _ in shown]), row("---", ["---"] * len(shown))]
    for name, f in figures.items():
        lines.append(row(short(name), [f"{f[key]:.2f}" for key, *_ in shown]))
    medians = [f"{statistics.median(f[key] for f in figures.values()):.2f}" for key, *_ in shown]
    lines += [row("**median**", medians),
              row("required: each, median", [f"{each:.3g}, {median:.3g}" for _, _, each, median in shown])]
    lines += ["", *(f"{short(name)} is skipped because Blender cannot read it: {what}." for name, what in unreadable_scenes.items())]
    return "\n".join(lines) + "\n"


def chart(figures):
    """Draws one row per scene, worst first, with one dot per ratio on a logarithmic axis."""
    dots = [("speed", "samples per processor second", COLORS[0]),
            ("time_trimmed", "processor time to equal error, without the worst 0.1 % of pixels", COLORS[2]),
            ("time", "the same, all pixels", COLORS[1])]
    dots = [d for d in dots if all(d[0] in f for f in figures.values())]
    values = [f[key] for f in figures.values() for key, *_ in dots]
    low, high = min(0.5, min(values) / 1.1), max(8, max(values) * 1.1)
    left, right, top, step = 190, 870, 126, 26
    bottom = top + step * len(figures)
    x = lambda ratio: left + (right - left) * math.log(ratio / low) / math.log(high / low)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 {bottom + 44}" width="900" height="{bottom + 44}" '
             f'font-family="system-ui, sans-serif" fill="{INK}">', '<rect width="100%" height="100%" fill="white"/>',
             text(16, 30, "How many times better than Cycles", size=20, more='font-weight="600"')]
    for i, (_, label, color) in enumerate(dots):
        parts += [f'<circle cx="24" cy="{50 + 20 * i}" r="6" fill="{color}"/>', text(38, 55 + 20 * i, label)]
    for ratio in (r for r in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if low <= r <= high):
        style = f'stroke="{INK if ratio == 1 else GRID}"'
        parts += [line(x(ratio), top - 10, x(ratio), bottom, style), text(x(ratio), bottom + 20, f"{ratio:g}", "middle")]
    for i, name in enumerate(sorted(figures, key=lambda n: figures[n][dots[-1][0]])):
        y = top + step * (i + 0.5)
        parts.append(text(left - 14, y + 5, short(name), "end"))
        parts += [f'<circle cx="{x(figures[name][key]):.1f}" cy="{y:.1f}" r="6" fill="{color}"/>' for key, _, color in dots]
    return "\n".join([*parts, "</svg>"]) + "\n"


def race(options, scene, ours, theirs):
    runs, loads = {"ours": [], "theirs": []}, []
    for _ in range(options.pairs):
        for side, renderer in (("theirs", theirs), ("ours", ours)):
            loads.append(os.getloadavg()[0])
            runs[side].append(renderer.render(scene, options.size, options.spp, 1, renderer.file("-speed.exr")))
    both = lambda wanted, *how: {side: errors(options, renderer, scene, *how) if wanted else []
                                 for side, renderer in (("ours", ours), ("theirs", theirs))}
    return {"speed": runs, "error": both(options.error_seeds), "adaptive": both(options.adaptive_spp, True),
            "load_average": loads}


def main():
    options = parse_arguments()
    options.cache = options.cache.resolve()
    views = json.loads((options.assets / "views.json").read_text())
    names = options.scenes or [name for name in views if name.startswith("scenes/")]
    pages, figures, unreadable_scenes = [], {}, {}
    record = json.loads(options.json.read_text()) if options.json and options.json.exists() else {}
    names = list(dict.fromkeys([*record, *names]))
    for name in names:
        if name not in views:
            sys.exit(f"race_cycles.py: {options.assets / 'views.json'} has no view of {name}")
        scene = (options.assets / name).resolve()
        try:
            if name not in record:
                record[name] = race(options, scene, Emberline(options, views[name]), Cycles(options, views[name]))
        except Unreadable as what:
            unreadable_scenes[name] = what
            continue
        raced = record[name]
        found = raced["speed"], raced["error"], raced["adaptive"]
        figures[name] = raced["ratios"] = ratios_of(*found)
        pages.append(table(options, name, *found, raced["load_average"]))
        print(pages[-1], file=sys.stderr if options.output else sys.stdout, flush=True)
        if options.json:  # after each scene, since all of them take hours
            options.json.write_text(json.dumps(record, indent=2))
    if not figures:
        sys.exit("race_cycles.py: Blender cannot read any of the scenes")
    if len(names) > 1:
        pages.insert(0, summary(figures, unreadable_scenes))
        print(pages[0], file=sys.stderr if options.output else sys.stdout)
    if options.output:
        options.output.write_text(time.strftime("Measured %Y-%m-%d.\n\n") + "\n".join(pages))
    if options.chart:
        options.chart.write_text(chart(figures))


if __name__ == "__main__":
    main()
