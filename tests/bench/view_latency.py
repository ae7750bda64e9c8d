"""Measures the latency from an edit to its first picture on the screen, with the real window on a virtual display,
and the cost of the window for an idle render.

    python3 tests/bench/view_latency.py build/release/bin/emberline SCENE [more arguments for `emberline view`]

Needs xvfb. Software OpenGL competes for the render's cores, unlike a graphics card.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "view"))
import display as screens  # noqa: E402


def measure(binary, words, size):
    screen = screens.Display(*size)
    try:
        with tempfile.TemporaryDirectory() as folder:
            report = pathlib.Path(folder) / "measured.json"
            subprocess.run([binary, "view", *words, "--forget", "--window", f"{size[0]}x{size[1]}", "--measure", str(report)],
                           env=screen.environment, check=True)
            return json.loads(report.read_text())
    finally:
        screen.close()


def render_pace(binary, words, driver, seconds):
    """Returns the samples per second of `render` with the same driver, without a window."""
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "r.json"
        subprocess.run([binary, "render", *words, "--driver", driver, "--spp", "4096", "--time-limit", str(seconds), "-q",
                        "-o", str(pathlib.Path(folder) / "r.exr"), "--report", str(report)], check=True)
        frame_report = json.loads(report.read_text())
        return frame_report["samples"]["total"] / frame_report["time"]["render_s"]


def row(name, summary):
    cells = []
    for key in ("first_picture_ms", "every_pixel_ms"):
        value = summary[key]
        cells += [f"{value['median']:.1f}", f"{value['p95']:.1f}"] if value else ["-", "-"]
    print(f"| {name} | {summary['first_picture_ms']['count']} | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--window", default="1640x860")
    parser.add_argument("--pace", action="store_true", help="also render without a window, to compare the pace")
    arguments, words = parser.parse_known_args()
    result = measure(arguments.binary, words, tuple(int(n) for n in arguments.window.split("x")))
    print("| edit | count | first picture: median ms | 95 % ms | every pixel: median ms | 95 % ms |")
    print("| --- | --- | --- | --- | --- | --- |")
    row("all", result["edits_ms"])
    for kind, summary in sorted(result["by_kind"].items()):
        row(kind, summary)
    busy = result["window_busy_ms"]
    print(f"\nthe window's thread is busy for: median {busy['median']:.1f} ms, 95 % {busy['p95']:.1f} ms, "
          f"maximum {busy['most']:.1f} ms")
    pace = result["idle"]["samples_per_s"]
    print(f"idle window: {pace / 1e6:.3f} M samples/s")
    if arguments.pace:
        driver = "adaptive" if result["driver"] == "live" else result["driver"]
        alone = render_pace(arguments.binary, words, driver, 8)
        print(f"`render --driver {driver}`: {alone / 1e6:.3f} M samples/s; "
              f"the window reaches {100 * pace / alone:.1f} %")


if __name__ == "__main__":
    main()
