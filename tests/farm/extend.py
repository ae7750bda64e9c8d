"""`emberline extend` adds samples to a finished frame. A uniform frame then has the bits of a frame that had all
samples from the start, even if the extension was killed, stopped and resumed. An adaptive frame reaches a lower
threshold. The old picture stays until the new picture is complete.

    extend.py build/release/bin/emberline scenes --only 'bucket kills'
"""

import random
import sys

import records
from farm import CHANNELS, EXIT_DONE, EXIT_INPUT, EXIT_STOPPED, EXIT_USAGE, Farm, Process, contents, pixels, report_of, \
    signal

FRAME = ["--size", "96x64", "--bucket-size", "16", "--threads", "2"]
FILES = {"out.exr.checkpoint"}
WAYS = {
    "bucket": ["--driver", "bucket"],
    "bisection": ["--driver", "bisection"],
    "independent": ["--driver", "bucket", "--sampler", "independent", "--streams", "2"],
    "light groups": ["--driver", "bisection", "--light-groups"],
}


def extend(farm, folder, *words):
    return Process([farm.program, "extend", "out.exr", *words, "--checkpoint-interval", "0.1"], folder)


def first_frame(farm, folder, case, settings):
    run = farm.run(folder, [*settings, "--resumable", "--quiet"])
    farm.check(run.code == 0, case, f"the frame failed: {run}")


def at_once(farm):
    for name, way in WAYS.items():
        case = f"{name} at once"
        if not farm.is_selected(case):
            continue
        settings = [*FRAME, *CHANNELS, *way]
        expected, _ = farm.reference([*settings, "--spp", "20"])
        folder = farm.folder(case)
        first_frame(farm, folder, case, [*settings, "--spp", "3"])
        for spp in ("8", "20"):
            run = extend(farm, folder, "--spp", spp, "--quiet").wait()
            farm.check(run.code == 0, case, f"should finish: {run}")
        farm.check_done(run, folder, expected, case, FILES)
        if name != "bisection":
            continue
        # The bisection driver has one film for the whole frame. Even if an extension is stopped immediately, the film
        # must not lose samples.
        run = extend(farm, folder, "--spp", "5000", "--quiet", "--time-limit", "0.01", "--report", "report.json").wait()
        samples = report_of(folder)["samples"]
        farm.check(samples["min"] >= 20, case, f"a pixel has lost samples: {samples}")


def interrupted(farm):
    """Kills and stops an extension repeatedly. The old picture must stay until the new picture replaces it."""
    for name in ("bucket", "bisection"):
        case = f"{name} kills"
        if not farm.is_selected(case):
            continue
        settings = ["--size", "160x120", "--threads", "2", *CHANNELS, *WAYS[name], "--bucket-size", "16"]
        expected, seconds = farm.reference([*settings, "--spp", "48"])
        folder = farm.folder(case)
        first_frame(farm, folder, case, [*settings, "--spp", "4"])
        old, chance, landed = pixels(folder / "out.exr"), random.Random(7), 0
        for i in range(60):
            process = extend(farm, folder, "--spp", "48", "--quiet")
            if i < 6:
                process.work(0.1 + 2 * chance.random() * 0.3 * seconds)
                process.signal(signal.SIGKILL if i % 2 == 0 else signal.SIGTERM)
            run = process.wait()
            if run.code == EXIT_DONE:
                break
            landed += 1
            # A SIGTERM that arrives before the program has installed its handlers kills the program.
            farm.check(run.code in (-signal.SIGKILL, -signal.SIGTERM, EXIT_STOPPED), case,
                       f"should be killed or stopped: {run}")
            farm.check(pixels(folder / "out.exr") == old, case,
                       "the old picture changed before the new one was complete")
        farm.check(landed >= 3, case, f"only {landed} of 6 signals arrived before it finished")
        farm.check_done(run, folder, expected, case, FILES)


def adaptive(farm):
    for name, settings, more in (
        ("adaptive budget", ["--driver", "adaptive", "--spp", "8"], ["--spp", "24"]),
        ("adaptive unbiased", ["--driver", "adaptive", "--spp", "8", "--unbiased"], ["--spp", "24"]),
        ("adaptive threshold", ["--driver", "adaptive", "--noise-threshold", "0.1", "--max-spp", "256"],
         ["--noise-threshold", "0.05"]),
        ("bucket threshold", ["--noise-threshold", "0.1", "--max-spp", "256"], ["--noise-threshold", "0.05"]),
    ):
        if not farm.is_selected(name):
            continue
        folder = farm.folder(name)
        first_frame(farm, folder, name, [*FRAME, *CHANNELS, *settings, "--report", "report.json"])
        before = report_of(folder)
        run = extend(farm, folder, *more, "--report", "report.json", "--quiet").wait()
        if not farm.check(run.code == 0, name, f"should finish: {run}"):
            continue
        after = report_of(folder)
        farm.check(after["samples"]["total"] > before["samples"]["total"], name, "it has no additional samples")
        farm.check(after["samples"]["min"] >= before["samples"]["min"], name, "a pixel has fewer samples than before")
        farm.check(after["error"]["estimate"] < before["error"]["estimate"], name, "its estimated error has not fallen")
        farm.check(after["checkpoint"]["earlier_samples"] == before["samples"]["total"], name,
                   "it did not start from the earlier samples")


def refused(farm):
    if not farm.is_selected("refused"):
        return
    folder = farm.folder("refused")
    first_frame(farm, folder, "refused", [*FRAME, "--spp", "4"])
    farm.run(folder, [*FRAME, "--spp", "4", "--sampler", "stratified", "--resumable", "--quiet"], output="jitter.exr")
    farm.run(folder, [*FRAME, "--spp", "4", "--sampler", "hierarchical", "--resumable", "--quiet"],
             output="weights.exr")
    farm.run(folder, [*FRAME, "--part", "1/2", "--spp", "4", "--quiet"], output="part.exr")
    farm.run(folder, [*FRAME, "--spp", "4", "--quiet"], output="plain.exr")
    farm.run(folder, [*FRAME, "--driver", "adaptive", "--noise-threshold", "0.1", "--resumable", "--quiet"],
             output="threshold.exr")
    farm.run(folder, [*FRAME, "--spp", "4", "--checkpoint", "named", "--resumable", "--quiet"], output="picture.exr")
    process = farm.start(folder, ["--spp", "4096", "--resumable", "--size", "640x480", "--quiet"], output="half.exr")
    process.wait_until((folder / "half.exr.checkpoint").exists)
    process.signal(signal.SIGTERM)
    process.wait()
    moved = folder / "moved.glb"
    moved.write_bytes(farm.scene().read_bytes())
    farm.run(folder, [*FRAME, "--spp", "4", "--resumable", "--quiet"], output="moved.exr", scene=moved)
    moved.unlink()
    before = contents(folder)
    for name, words, code, parts in (
        ("less", ["out.exr", "--spp", "2"], EXIT_USAGE, ["already has 4"]),
        ("nothing", ["out.exr"], EXIT_USAGE, ["--spp"]),
        ("threshold", ["out.exr", "--spp", "8", "--noise-threshold", "0.1"], EXIT_USAGE, ["--noise-threshold"]),
        ("less than its limit", ["threshold.exr", "--max-spp", "16"], EXIT_USAGE, ["--max-spp", "already has 4096"]),
        ("another limit", ["threshold.exr", "--spp", "2"], EXIT_USAGE, ["--spp", "rendered without this limit"]),
        ("no picture", ["named", "--spp", "8"], EXIT_USAGE, ["-o"]),
        ("jitter", ["jitter.exr", "--spp", "8"], EXIT_INPUT, ["stratified"]),
        ("hierarchical", ["weights.exr", "--spp", "8"], EXIT_INPUT, ["hierarchical"]),
        ("part", ["part.exr.part-1-of-2.checkpoint", "--spp", "8"], EXIT_INPUT, ["part"]),
        ("plain", ["plain.exr", "--spp", "8"], EXIT_INPUT, ["plain.exr.checkpoint"]),
        ("moved", ["moved.exr", "--spp", "8"], EXIT_INPUT, ["moved.glb"]),
        ("other scene", ["moved.exr", "--spp", "8", "--scene", farm.scene("glass_metal")], EXIT_INPUT, ["scene"]),
    ):
        case = f"refused {name}"
        if farm.is_selected(case):
            run = Process([farm.program, "extend", *words, "--quiet"], folder).wait()
            farm.check_refused(run, folder, before, case, (code,), parts)
    run = Process([farm.program, "extend", "named", "--spp", "8", "-o", "picture.exr", "--quiet"], folder).wait()
    farm.check(run.code == EXIT_DONE, "named checkpoint", f"should extend the picture that -o names: {run}")
    run = Process([farm.program, "extend", "moved.exr", "--spp", "8", "--scene", farm.scene(), "--quiet"], folder).wait()
    farm.check(run.code == EXIT_DONE, "moved scene", f"should use the scene that --scene names: {run}")


def damaged(farm):
    """Damages checkpoints of frames and extends the frames. If the checkpoint consists of tiles, the damaged tiles must
    be rendered again, as with --resume. If it has a single film, it must be refused. The damage is a flipped bit in the
    packed bytes, which the checksum reveals; a wrong state with a valid checksum; or a truncated file."""
    zstd = records.zstd_of(farm.program)
    for name, way in WAYS.items():
        settings = [*FRAME, *CHANNELS, *way]
        by_tiles = name != "bisection" and name != "light groups"
        for kind in ("bit", "state", "cut"):
            case = f"{name} {kind}"
            if not farm.is_selected(case) or (kind == "state" and not zstd):
                continue
            expected, _ = farm.reference([*settings, "--spp", "8"])
            folder = farm.folder(case)
            first_frame(farm, folder, case, [*settings, "--spp", "3"])
            file = folder / "out.exr.checkpoint"
            data = bytearray(file.read_bytes())
            head, found = records.parsed_file(bytes(data), zstd)
            record = found[1] if by_tiles else found[0]
            if kind == "bit":
                data[record.at + records.RECORD_START + record.packed_size // 2] ^= 16
            elif kind == "cut":
                data = data[:-len(found[-1].packed or b"x") // 2]
            else:
                state = b"\xff" * 64 + record.data[64:]
                again = records.Record(record.kind, record.number, state)
                data = records.packed_file(head, [again if old is record else old for old in found])
            file.write_bytes(bytes(data))
            before = contents(folder)
            run = extend(farm, folder, "--spp", "8", *([] if by_tiles else ["--quiet"])).wait()
            if not by_tiles:
                farm.check_refused(run, folder, before, case, {EXIT_INPUT}, ["out.exr.checkpoint: "])
                continue
            farm.check("out.exr.checkpoint: " in run.err and "rendered again" in run.err, case,
                       f"should say that tiles are rendered again: {run}")
            farm.check_done(run, folder, expected, case, FILES)


def main():
    farm = Farm(__doc__)
    for test in (at_once, interrupted, adaptive, damaged, refused):
        test(farm)
    farm.done()


sys.exit(main())
