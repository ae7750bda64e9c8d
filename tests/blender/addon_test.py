#!/usr/bin/env python3
"""Tests the add-on in a real Blender without a display, and compares its pictures with Cycles'.

    tests/blender/addon_test.py CASE... [--emberline build/release/bin/emberline] [--blender blender] [--keep DIR]

Most cases are functions of in_blender.py. The cases `cancel`, `killed` and `two_at_once` control Blender from outside.
The cases of in_viewport.py need xvfb-run. `all` runs every case, and `list` prints the cases. The exit code is 77 if
Blender is not installed, or if it lacks NumPy, Cycles or the glTF exporter. ctest then counts the test as skipped.
"""
import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
VIEWPORT = ("viewport_shows", "viewport_changes", "viewport_borders", "viewport_large", "viewport_ends", "viewport_animation")
FROM_OUTSIDE = ("cancel", "killed", "two_at_once")
CASES = (
    "labels_and_tooltips", "compare", "light_units", "refusals", "no_pixels", "missing_library", "border", "unusual_paths", "layers", "animation", "nothing_to_see", "environments",
    "filters", "images_as_marked", "tiles_and_sequences", "holdouts", "motion_closed_form", "motion_compare", "shows_and_tells",
    "as_installed", *FROM_OUTSIDE, *VIEWPORT,
)  # fmt: skip
SAYS = {
    "nothing_to_see": "Warning: Emberline: the scene has no mesh and no light",
    "missing_library": "Warning: Emberline: library.blend: the file",
    "tiles_and_sequences": "Warning: Emberline: Plane: look: the image 'tiles.1001.png' has 2 tiles",
}  # what the log must contain; it is complete when Blender has ended
NEEDS = "import numpy, _cycles, io_scene_gltf2; print('has all')"


def environment(options, **more):
    """Returns the environment of Blender. A Blender that uses the system's Python looks for it along PATH, so the
    system's folders come first there."""
    path = os.pathsep.join([str(Path(shutil.which(options.blender)).parent), "/usr/bin", "/bin"])
    return {**os.environ, "PATH": path, **more}


def start(options, case, folder):
    """Starts Blender, which writes to a log file. It would block if it wrote to a pipe that nothing reads."""
    command = [options.blender, "-b", "--factory-startup", "-P", HERE / "in_blender.py", "--"]
    temporary = folder / "tmp mit Ä"
    temporary.mkdir(parents=True, exist_ok=True)
    # BLENDER_USER_RESOURCES is also the folder of add-ons that a test installs.
    more = {"TMPDIR": str(temporary), "BLENDER_USER_RESOURCES": str(folder / "user"), "HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
    if case in VIEWPORT:
        # xvfb-run allows no blanks in TMPDIR or in the server's arguments.
        screen = ["xvfb-run", "-a", "-s", f"-screen 0 960x600x24 -fbdir {options.screen}", "env", f"TMPDIR={temporary}"]
        window = ["--factory-startup", "--no-window-focus", "-p", "0", "0", "960", "600"]
        more |= {"LIBGL_ALWAYS_SOFTWARE": "1", "EMBERLINE_TEST_SCREEN": options.screen}
        del more["TMPDIR"]
        command = [*screen, options.blender, *window, "-P", HERE / "in_viewport.py", "--"]
    with open(folder / "log.txt", "wb") as log:
        return subprocess.Popen(
            [*command, case, folder, Path(options.emberline).resolve()],
            stdout=log,
            stderr=subprocess.STDOUT,
            env=environment(options, **more),
        )


def log(folder):
    return (folder / "log.txt").read_text(errors="replace")


def finish(process, folder, case, codes=(0,)):
    code = process.wait(240)
    said = log(folder)
    if code not in codes or f"passed {case}" not in said or SAYS.get(case, "") not in said:
        sys.exit(f"{said[-4000:]}\n{case}: Blender ended with {code}")
    print("\n".join(line for line in said.splitlines() if re.match(r"passed|\w+: within|.* after \S+ m?s", line)))
    left = [p for p in (folder / "tmp mit Ä").rglob("emberline*")]
    if left:
        sys.exit(f"{case}: left behind: {left}")


def child_of(process, folder):
    """Waits until the renderer, which is a child of Blender, is at work. Returns its process id."""
    for _ in range(600):
        child = re.search(r"child (\d+)", log(folder))
        if child or process.poll() is not None:
            break
        time.sleep(0.05)
    if not child:
        sys.exit(f"{log(folder)}\nno render began")
    time.sleep(0.5)
    return int(child.group(1))


def running(process_id):
    """Returns whether the process runs. A zombie does not count, because its new parent may reap it late."""
    try:
        return Path(f"/proc/{process_id}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def cancel(options, folder):
    process = start(options, "long_render", folder)
    child = child_of(process, folder)
    os.kill(process.pid, signal.SIGINT)  # has the same effect as Esc in the user interface
    finish(process, folder, "long_render", codes=(0, 1))  # these are Blender's exit codes after Ctrl-C
    if running(child):
        sys.exit("cancel: the renderer goes on")


def killed(options, folder):
    """Kills Blender in mid-frame. The renderer must then end and remove its files."""
    process = start(options, "long_render", folder)
    child = child_of(process, folder)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    for _ in range(1200):
        time.sleep(0.05)
        left = list((folder / "tmp mit Ä").rglob("emberline*"))
        if not running(child) and not left:
            print("passed killed")
            return
    sys.exit(f"killed: the renderer {'goes on' if running(child) else 'has ended'}; left behind: {left}")


def two_at_once(options, folder):
    folders = [folder / "eins", folder / "zwei"]
    running = [start(options, "one_of_two", f) for f in folders]
    for process, f in zip(running, folders):
        finish(process, f, "one_of_two")
    means = [re.search(r"mean (\S+)", log(f)).group(1) for f in folders]
    if means[0] != means[1]:
        sys.exit(f"two at once: {means}")


def run(options, case):
    if case in VIEWPORT and not shutil.which("xvfb-run"):
        print("no xvfb-run: nothing is tested")
        return 77
    with tempfile.TemporaryDirectory() as scratch:
        options.screen = scratch
        folder = options.keep or Path(scratch) / "Ordner mit Umläuten"
        folder.mkdir(parents=True, exist_ok=True)
        if case in FROM_OUTSIDE:
            globals()[case](options, folder)
        else:
            finish(start(options, case, folder), folder, case)
    return 0


def has_all(options):
    has = [options.blender, "-b", "--factory-startup", "--python-expr", NEEDS]
    found = subprocess.run(has, capture_output=True, text=True, errors="replace", env=environment(options))
    return "has all" in found.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="+")
    parser.add_argument("--emberline", default=ROOT / "build/release/bin/emberline")
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--keep", type=Path, help="leave the files in this folder")
    options = parser.parse_args()
    if options.cases == ["list"]:
        print(";".join(CASES), end="")
        return 0
    if not shutil.which(options.blender):
        print("no blender: nothing is tested")
        return 77
    failed = []
    for case in CASES if options.cases == ["all"] else options.cases:
        try:
            if run(options, case):
                return 77
        except SystemExit as fault:
            print(fault)
            failed.append(case)
    # Check this only after a failure, because it takes as long as a short case.
    if failed and not has_all(options):
        print("blender has no NumPy, no Cycles or no glTF exporter: nothing is tested")
        return 77
    if failed:
        sys.exit(f"failed: {', '.join(failed)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
