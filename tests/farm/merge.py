"""Merged parts of a frame have the bits of the whole frame. Parts made with --part are tested with and without a noise
threshold, with light groups, with holes and with heatmaps. Merged sample ranges differ from the whole frame only by the
rounding of sums in another order. Merged frames with different seeds are weighted by their samples. `emberline merge`
refuses parts that do not belong together, with one line.

    merge.py build/release/bin/emberline scenes --only ranges
"""

import json
import random
import resource
import sys

from farm import CHANNELS, EXIT_INPUT, EXIT_USAGE, Farm, Process, contents, pixels, report_of
from records import packed_file, parsed_file

FRAME = ["--size", "96x64", "--bucket-size", "16", "--threads", "2"]
WHOLE = {
    "uniform": ["--spp", "8"],
    "threshold": ["--noise-threshold", "0.06", "--max-spp", "64"],
    "unbiased": ["--noise-threshold", "0.06", "--unbiased", "--spp", "24"],
    "streams": ["--spp", "16", "--streams", "2", "--sampler", "independent"],
    "crop": ["--spp", "4", "--crop", "5,3,90,61", "--bucket-order", "random"],
    "light groups": ["--spp", "4", "--light-groups"],
    "clamped": ["--spp", "8", "--clamp-indirect", "0.2", "--light-groups"],
    "filter": ["--spp", "4", "--filter", "gaussian"],
}


def merge(farm, folder, parts, *more, output="out.exr"):
    return Process([farm.program, "merge", "-o", output, *parts, *more, "--quiet"], folder).wait()


def rendered(farm, folder, case, settings, output="out.exr"):
    run = farm.run(folder, [*settings, "--quiet"], output=output)
    farm.check(run.code == 0, case, f"the part failed: {run}")


def parts_of(farm, folder, case, settings, count, order):
    for k in order:
        rendered(farm, folder, case, [*settings, "--part", f"{k}/{count}"])
    return [f"out.exr.part-{k}-of-{count}.checkpoint" for k in order]


def tiles(farm):
    for number, (name, settings) in enumerate(WHOLE.items()):
        case = f"tiles {name}"
        if not farm.is_selected(case):
            continue
        settings = [*FRAME, *settings, *CHANNELS]
        expected, _ = farm.reference(settings)
        folder = farm.folder(case)
        count = 2 + number % 4
        order = random.Random(number).sample(range(1, count + 1), count)
        parts = parts_of(farm, folder, case, settings, count, order)
        farm.check(set(contents(folder)) == set(parts), case, "a part left files other than its checkpoint")
        run = merge(farm, folder, parts, "--report", "report.json")
        farm.check_done(run, folder, expected, case, {"report.json", *parts})
        once = farm.folder(case + " once")
        farm.run(once, [*settings, "--quiet", "--report", "report.json"])
        for key in ("samples", "rays", "error", "numerics", "clamped"):
            farm.check(report_of(folder)[key] == report_of(once)[key], case, f"'{key}' in the report differs")


def ranges(farm):
    """Merges sample ranges. The sums are added in another order, so floats may differ in the last bit."""
    for driver in ("bucket", "bisection"):
        case = f"ranges {driver}"
        if not farm.is_selected(case):
            continue
        settings = [*FRAME, *CHANNELS, "--driver", driver]
        expected, _ = farm.reference([*settings, "--spp", "24"])
        folder = farm.folder(case)
        parts = []
        for a, b in ((0, 7), (16, 24), (7, 16)):
            rendered(farm, folder, case, [*settings, "--sample-range", f"{a}-{b}"])
            parts.append(f"out.exr.samples-{a}-{b}.checkpoint")
        run = merge(farm, folder, parts)
        whole = farm.folder(case + " whole")
        farm.run(whole, [*settings, "--spp", "24", "--quiet"])
        if not farm.check(run.code == 0, case, f"should finish: {run}"):
            continue
        # Compare the pictures by their largest difference, which the program measures.
        compared = Process([farm.program, "compare", "out.exr", whole / "out.exr", "--json"], folder).wait()
        farm.check(json.loads(compared.out)["max_abs"] < 1e-6, case, f"the picture differs: {compared.out}")
        print(f"{case}: {'the same bits' if pixels(folder / 'out.exr') == expected else 'different bits'}")


def ranges_by_parts(farm):
    """Merges two sample ranges, each of which consists of two parts."""
    case = "ranges by parts"
    if not farm.is_selected(case):
        return
    settings = [*FRAME, *CHANNELS]
    expected, _ = farm.reference([*settings, "--spp", "8"])
    folder = farm.folder(case)
    for span in ("0-4", "4-8"):
        for k in (1, 2):
            rendered(farm, folder, case, [*settings, "--sample-range", span, "--part", f"{k}/2"])
    parts = sorted(contents(folder))
    farm.check(len(parts) == 4, case, f"should be four parts: {parts}")
    farm.check_done(merge(farm, folder, parts), folder, expected, case, set(parts))


def seeds(farm):
    """Merges frames with different seeds. The merged picture is their mean, weighted by their samples, and its error
    estimate combines their estimates."""
    for driver in ("adaptive", "bucket"):
        case = f"seeds {driver}"
        if not farm.is_selected(case):
            continue
        folder = farm.folder(case)
        threshold = ["--noise-threshold", "0.05", "--max-spp", "256"] if driver == "bucket" else []
        for seed, spp in ((1, 16), (2, 16)):
            more = threshold or ["--spp", str(spp)]
            run = farm.run(folder, [*FRAME, *CHANNELS, "--driver", driver, *more, "--seed", str(seed), "--resumable",
                                    "--report", f"{seed}.json", "--quiet"], output=f"{seed}.exr")
            farm.check(run.code == 0, case, f"the part failed: {run}")
        run = merge(farm, folder, ["1.exr.checkpoint", "2.exr.checkpoint"], "--report", "report.json")
        if not farm.check(run.code == 0, case, f"should finish: {run}"):
            continue
        one, two, both = (report_of(folder, name) for name in ("1.json", "2.json", "report.json"))
        n = [report["samples"]["total"] for report in (one, two)]
        farm.check(both["samples"]["total"] == sum(n), case, "samples are lost")
        e = [report["error"]["estimate"] for report in (one, two)]
        expected = ((n[0] * e[0]) ** 2 + (n[1] * e[1]) ** 2) ** 0.5 / sum(n)
        farm.check(abs(both["error"]["estimate"] - expected) < 1e-9, case, "the error estimate is wrong")


def refused(farm):
    if not farm.is_selected("refused"):
        return
    case = "refused"
    folder = farm.folder(case)
    settings = [*FRAME, "--spp", "2"]
    parts = parts_of(farm, folder, case, settings, 3, (1, 2, 3))
    rendered(farm, folder, case, [*settings, "--seed", "9", "--part", "1/3"], output="seed.exr")
    rendered(farm, folder, case, [*settings[:-1], "3", "--part", "1/3"], output="spp.exr")
    rendered(farm, folder, case, [*settings, "--part", "1/3", "--max-depth", "3"], output="depth.exr")
    rendered(farm, folder, case, [*FRAME, "--sample-range", "2-4"], output="range.exr")
    rendered(farm, folder, case, settings, output="picture.exr")
    damaged = bytearray((folder / parts[1]).read_bytes())
    damaged[len(damaged) * 2 // 3] ^= 4
    (folder / "damaged").write_bytes(damaged)
    (folder / "cut").write_bytes(damaged[: len(damaged) // 2])
    # Make two frames with a single film each. The second frame claims to have other light groups.
    for seed in ("1", "2"):
        rendered(farm, folder, case, [*settings, "--driver", "bisection", "--light-groups", "--resumable", "--seed", seed],
                 output=f"lights{seed}.exr")
    lights = "lights2.exr.checkpoint"
    head, records = parsed_file((folder / lights).read_bytes())
    head = json.loads(head)
    farm.check(len(head["light layers"]) > 0, case, "no light groups")
    head["light layers"].pop()
    (folder / lights).write_bytes(packed_file(json.dumps(head), records))
    # Make a file of a few kilobytes that claims to have millions of buckets.
    head, records = parsed_file((folder / parts[0]).read_bytes())
    head = json.loads(head)
    for where in ("settings", "schedule"):
        head[where].update({key: value for key, value in (("size", "4096x4096"), ("bucket-size", "1"))
                            if key in head[where]})
    (folder / "forged").write_bytes(packed_file(json.dumps(head), records))
    before = contents(folder)
    part = "part-1-of-3.checkpoint"
    for name, files, code, words in (
        ("hole", parts[:2], EXIT_INPUT, ["lack", "of 24 buckets"]),
        ("twice", [*parts, parts[2]], EXIT_INPUT, [parts[2], "the same samples"]),
        ("seed alone", [*parts, f"seed.exr.{part}"], EXIT_INPUT, ["lack"]),
        ("spp", [*parts[1:], f"spp.exr.{part}"], EXIT_INPUT, ["--spp: 3 (now 2)"]),
        ("depth", [*parts[1:], f"depth.exr.{part}"], EXIT_INPUT, ["--max-depth"]),
        ("range", ["range.exr.samples-2-4.checkpoint"], EXIT_INPUT, ["samples 0 to 1"]),
        ("picture", ["picture.exr"], EXIT_INPUT, ["not an Emberline checkpoint"]),
        ("lists", ["forged", "--memory-limit", "100M"], EXIT_INPUT, ["forged", "--memory-limit"]),
        ("missing", [*parts, "missing"], EXIT_INPUT, ["missing"]),
        ("damaged", [parts[0], "damaged", parts[2]], EXIT_INPUT, ["damaged"]),
        ("cut", [parts[0], "cut", parts[2]], EXIT_INPUT, ["lack"]),
        ("light groups", ["lights1.exr.checkpoint", lights], EXIT_INPUT, [lights, "light groups"]),
        ("heatmap", [*parts, "--heatmap", "h.png", "--heatmap-of", "time"], EXIT_USAGE, ["--aov time"]),
        ("output is a part", [*parts, "-o", parts[0]], EXIT_USAGE, [parts[0]]),
        ("no parts", [], EXIT_USAGE, ["parts"]),
    ):
        case = f"refused {name}"
        if farm.is_selected(case):
            farm.check_refused(merge(farm, folder, files), folder, before, case, (code,), words)


def cannot_be_cut(farm):
    """Checks that --sample-range is refused for samplers whose samples depend on the total number of samples."""
    for sampler in ("stratified", "blue_noise", "hierarchical"):
        case = f"not cut {sampler}"
        if farm.is_selected(case):
            folder = farm.folder(case)
            run = farm.run(folder, [*FRAME, "--sample-range", "0-4", "--sampler", sampler])
            farm.check_refused(run, folder, {}, case, (EXIT_USAGE,), ["--sampler", "sobol, poisson_disk or independent"])


def complete(picture):
    """Returns whether the header says that the picture is complete."""
    name = b"emberline:complete\0string\0"
    at = picture.read_bytes().index(name) + len(name) + 4
    return picture.read_bytes()[at : at + 5] != b"false"


def missing_samples(farm):
    case = "missing samples"
    if not farm.is_selected(case):
        return
    folder = farm.folder(case)
    for samples in ("0-2", "2-4", "4-6"):
        rendered(farm, folder, case, [*FRAME, "--sample-range", samples])
    parts = [f"out.exr.samples-{samples}.checkpoint" for samples in ("0-2", "2-4", "4-6")]
    for chosen, whole in ((parts, True), ([parts[0], parts[2]], False)):
        run = merge(farm, folder, chosen, "--allow-holes")
        farm.check(run.code == 0 and complete(folder / "out.exr") == whole, case, f"{len(chosen)} parts: {run}")


def many_parts(farm):
    """Merges parts while the process may open only about as many files as there are parts."""
    case = "many parts"
    if not farm.is_selected(case):
        return
    folder = farm.folder(case)
    settings = ["--size", "48x24", "--bucket-size", "8", "--threads", "1", "--spp", "1"]
    parts = parts_of(farm, folder, case, settings, 18, range(1, 19))
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (20, hard))
    try:
        run = merge(farm, folder, parts)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
    expected, _ = farm.reference(settings)
    farm.check_done(run, folder, expected, case, parts)


def holes(farm):
    case = "holes"
    if not farm.is_selected(case):
        return
    folder = farm.folder(case)
    settings = [*FRAME, "--spp", "2", *CHANNELS]
    parts = parts_of(farm, folder, case, settings, 3, (1, 3))
    run = merge(farm, folder, parts, "--allow-holes", "--report", "report.json")
    farm.check(run.code == 0, case, f"should finish: {run}")
    report = report_of(folder)
    farm.check(report["samples"]["min"] == 0 and report["samples"]["total"] == 96 * 64 * 2 * 2 // 3, case,
               f"wrong sample counts: {report['samples']}")
    # Part 3 is rendered again, which replaces the old part 3. With part 2, the parts form the whole frame.
    rendered(farm, folder, case, [*settings, "--part", "3/3"])
    rendered(farm, folder, case, [*settings, "--part", "2/3"])
    expected, _ = farm.reference(settings)
    run = merge(farm, folder, [*parts, "out.exr.part-2-of-3.checkpoint"])
    farm.check(run.code == 0 and pixels(folder / "out.exr") == expected, case, f"should be the whole frame: {run}")


def main():
    farm = Farm(__doc__)
    for test in (tiles, ranges, ranges_by_parts, seeds, refused, cannot_be_cut, missing_samples, many_parts, holes):
        test(farm)
    farm.done()


sys.exit(main())
