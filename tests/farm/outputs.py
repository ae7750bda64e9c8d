"""If a signal ends a run, each of its outputs is complete or absent: pictures, heatmaps, reports and settings.

This test sends random signals at every stage (start, load, frame, end of the frame), and SIGKILL while files are
written. In half of the cases, there are outputs of an earlier run, which must be unchanged or replaced by complete
outputs. After each signal, the frame is rendered again. It must then have the right bits, and no other file may be left
in the folder.

To repeat one case, use its number from the failure's message:

  outputs.py build/release/bin/emberline scenes --seed 1 --only 'kill 17'

The random numbers depend on the seed and the case; when a signal arrives also depends on the machine.
"""

import json
import os
import random
import struct
import time
import zlib

from farm import CHANNELS, DRIVERS, EXIT_DONE, EXIT_STOPPED, LONG, Farm, contents, pixels, signal
from frame_bits import chunks

FRAME = ["--size", "96x72", "--bucket-size", "16", "--threads", "2", *CHANNELS]
SECONDS = 0.4 if LONG else 0.25  # a frame takes at least this long
OUTPUTS = ["-o", "out.png", "-o", "out.jpg", "--heatmap", "heat.png", "--report", "report.json", "--report",
           "report.html", "--save-settings", "settings.json", "--progress-file", "progress.json", "--verbose"]
RESULTS = {"out.exr", "out.png", "out.jpg", "heat.png", "report.json", "report.html", "settings.json", "progress.json"}
CHECKPOINT = "out.exr.checkpoint"
LOGGED = {"start": "", "load": "emberline ", "frame": "loaded in"}  # the log line with which a stage begins
STAGES = {"signal": ("start", "load", "frame", "end"), "kill": ("tiles", "end")}
SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT, signal.SIGXCPU, signal.SIGUSR1)


def check_exr(data):
    for tile in chunks(data):
        assert len(tile) == 20 + struct.unpack_from("<i", tile, 16)[0], "a tile is cut short"


def check_png(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "not a PNG"
    at, packed, kind = 8, b"", b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + size]
        assert struct.unpack_from(">I", data, at + 8 + size)[0] == zlib.crc32(kind + body), "a wrong checksum"
        packed, at = packed + (body if kind == b"IDAT" else b""), at + 12 + size
    assert kind == b"IEND", "the end is missing"
    zlib.decompress(packed)


def check_jpeg(data):
    assert data[:2] == b"\xff\xd8" and data[-2:] == b"\xff\xd9", "the start or the end is missing"


def check_page(data):
    assert data.rstrip().endswith(b"</html>"), "the end is missing"


CHECKS = {".exr": check_exr, ".png": check_png, ".jpg": check_jpeg, ".html": check_page, ".json": json.loads}


def find_damage(path):
    """Returns why a file is incomplete, or an empty string if it is complete."""
    try:
        CHECKS[path.suffix](path.read_bytes())
    except (AssertionError, ValueError, KeyError, IndexError, struct.error, zlib.error) as error:
        return f"{type(error).__name__} {error}"
    return ""


def read_log(process):
    """Returns the contents of stderr so far. Leaves the file position unchanged, because the program uses it, too."""
    return os.pread(process.log[1].fileno(), 1 << 20, 0).decode(errors="replace")


def write_times(folder):
    """Returns when the outputs that a run writes at the end of a frame were written: its pictures and reports."""
    names = RESULTS - {"progress.json", "settings.json"}
    return {name: (folder / name).stat().st_mtime_ns for name in names if (folder / name).exists()}


def size_of(path):
    try:
        return path.stat().st_size
    except FileNotFoundError:  # the file has meanwhile got its final name
        return 0


def wait_for_stage(process, folder, stage, seconds, dice):
    before = write_times(folder)
    if stage == "tiles":
        process.wait_until(lambda: any(map(size_of, folder.glob("*.emberline.part-*"))))
    elif stage == "end":  # some outputs already have their final names, and others do not yet
        process.wait_until(lambda: write_times(folder) != before)
    else:
        process.wait_until(lambda: LOGGED[stage] in read_log(process))
    if pause := {"start": 0.05, "load": 0.05, "end": 0.003}.get(stage):
        time.sleep(dice.uniform(0, pause))
    else:
        process.work(dice.uniform(0, 2 * 0.6 * seconds))


def disturbed(farm, kind, number):
    """Starts a run, sends it a signal and checks its outputs. Returns the stage in which the signal was sent, and
    whether the process was still running."""
    case, seed = f"{kind} {number}", farm.options.seed
    dice = random.Random(f"{seed} {case}")
    driver, resume = DRIVERS[number % len(DRIVERS)], dice.random() < 0.5
    stage = STAGES[kind][number // len(DRIVERS) % len(STAGES[kind])]
    number_sent = signal.SIGKILL if kind == "kill" else dice.choice(SIGNALS)
    replay = f"--seed {seed} --only '{case}'"
    settings = [*FRAME, "--driver", driver]
    settings += ["--spp", str(farm.samples_for(SECONDS, settings))]
    expected, seconds = farm.reference(settings)
    folder = farm.folder(case)
    before = {}
    if dice.random() < 0.5:  # an earlier run has left outputs
        run = farm.run(folder, [*FRAME, "--spp", "1", *OUTPUTS])
        farm.check(run.code == EXIT_DONE, case, f"the earlier run failed: {run}", replay)
        before = contents(folder)

    command = [*settings, *OUTPUTS, *(["--resume", "--checkpoint-interval", "0.1"] if resume else [])]
    process = farm.start(folder, command)
    wait_for_stage(process, folder, stage, seconds, dice)
    landed = process.running()
    process.signal(number_sent)
    run = process.wait()

    outcome = f"{number_sent.name} in {stage} of {driver}{', resumed' if resume else ''}: {run}"
    codes = {-number_sent, EXIT_DONE} | ({EXIT_STOPPED} if kind == "signal" else set())
    farm.check(run.code in codes, case, outcome, replay)
    for name in RESULTS & contents(folder).keys():
        damage = find_damage(folder / name)
        farm.check(not damage, case, f"{name} is incomplete ({damage}). {outcome}", replay)
    for name in before:
        farm.check((folder / name).exists(), case, f"{name} of the earlier run is gone. {outcome}", replay)
    out = folder / "out.exr"
    if out.exists() and contents(folder)["out.exr"] != before.get("out.exr") and run.code != EXIT_STOPPED:
        farm.check(pixels(out) == expected, case, f"the picture's bits differ. {outcome}", replay)
    if run.code >= 0:  # a run that was not killed must have removed its unfinished files
        stray = contents(folder).keys() - RESULTS - {CHECKPOINT}
        farm.check(not stray, case, f"stray files: {stray}. {outcome}", replay)

    run = farm.run(folder, command)
    if farm.check_done(run, folder, expected, case, RESULTS, replay):
        for name in RESULTS:
            damage = find_damage(folder / name)
            farm.check(not damage, case, f"{name} of the next run is incomplete ({damage})", replay)
    return stage, landed


def main():
    farm = Farm(__doc__, signals=(60, "number of signals, at every stage [60]"),
                kills=(60, "number of kills while files are written [60]"), seed=(1, "seed of the random choices [1]"))
    print(f"seed {farm.options.seed}", flush=True)
    landed = {}
    for kind, count in (("signal", farm.options.signals), ("kill", farm.options.kills)):
        for number in range(count):
            if farm.options.only and farm.options.only != f"{kind} {number}":
                continue
            stage, found = disturbed(farm, kind, number)
            landed.setdefault(f"{kind}, {stage}", []).append(found)
    for stage, found in landed.items():
        print(f"{stage}: {sum(found)} of {len(found)} signals hit a running process")
    farm.check(farm.options.only or sum(map(sum, landed.values())) * 3 >= sum(map(len, landed.values())) * 2, "all",
               "too few signals hit a running process")
    farm.done()


main()
