"""A forged checkpoint with valid checksums does no harm: the run refuses it, or renders a picture.

The forged checkpoints have absurd headers; records with absurd kinds, numbers and sizes; the state of another driver;
sums that are NaN or counts that are too large; or the state of a real checkpoint in which some bytes or numbers were
changed. Each run must end in time, without a signal, and use little memory. It must either finish with a complete
picture, or refuse: print one line of limited length on stderr, write nothing, and leave the file unchanged. To run one
case, give its name or a part of its name:

  hostile.py build/release/bin/emberline scenes --driver adaptive --only 'mutation 17'
"""

import json
import pathlib
import random
import struct

import records
from farm import CHANNELS, DRIVERS, EXIT_DONE, EXIT_INPUT, EXIT_RENDER_FAILED, LONG, SANITIZED, Farm, \
    contents, largest_child, pixels
from records import BLOCK, END, TILE, Record, file_start, packed_file

FRAME = ["--size", "16x12", "--bucket-size", "8", "--spp", "4", "--threads", "1", "--quiet", *CHANNELS]
SETTINGS = {"bucket": (), "bucket streams": ("--streams", "2"), "bisection": (), "bisection lights": ("--light-groups",),
            "adaptive": ("--spp", "16"), "adaptive unbiased": ("--spp", "16", "--unbiased"),
            "adaptive streams": ("--spp", "16", "--streams", "2"),
            # A time limit stops these frames midway, so that the driver's state has unfinished plans.
            "bisection stopped": ("--spp", "200"), "adaptive stopped": ("--spp", "200"),
            "adaptive threshold stopped": ("--noise-threshold", "0.002", "--max-spp", "300")}
CHECKPOINT = "the.checkpoint"
SECONDS = 600 if SANITIZED else 60  # limit on wall-clock time; it is long because machines may be busy
MEMORY = (3 << 30) if SANITIZED else (400 << 20)  # limit on memory; the process needs 20 MiB
ADDRESSES = None if SANITIZED else 4 << 30  # limit on the address space, which stops a run that uses endless memory
LONGEST_LINE = 20000
NAN, INFINITY = struct.pack("<f", float("nan")), struct.pack("<f", float("inf"))


def heads(head):
    """Yields headers, most of them absurd, each with the name of its case."""
    good = json.loads(head)

    def changed(**members):
        return json.dumps({**good, **members})

    deep = "[" * 100000 + "]" * 100000
    deep_objects = '{"a":' * 50000 + "1" + "}" * 50000
    yield "empty", b""
    yield "not JSON", b"{"
    yield "not UTF-8", head.replace(b"sobol", b"\xff\xfe\xc0\x80\x00")
    yield "a number", b"1"
    yield "null", b"null"
    yield "a list", b"[]"
    yield "an empty object", b"{}"
    yield "nested, elsewhere", head[:-2] + b',"x":' + deep.encode() + b"}"
    for name, nested in (("lists", deep), ("objects", deep_objects)):
        yield f"nested {name}", nested.encode()
        yield f"nested {name}, bits", json.dumps({**good, "bits": "@"}).replace('"@"', nested).encode()
        yield f"nested {name}, version", ('{"bits":0,"emberline":' + nested + "}").encode()
        yield f"nested {name}, setting", changed(settings={"spp": "@"}).replace('"@"', nested).encode()
        yield f"nested {name}, machine", changed(machine={"embree": "@"}).replace('"@"', nested).encode()
    for part in ("emberline", "bits", "settings", "inputs", "machine"):
        for value in (None, 1, -1, 1e300, True, "x", [], [1], {"x": 1}, {"x": {"y": []}}):
            yield f"{part} {json.dumps(value)}", changed(**{part: value}).encode()
    yield "numbers for texts", changed(settings={name: 1 for name in good["settings"]}).encode()
    yield "lines and escapes", changed(settings={**good["settings"], "a\nemberline: error: b\x1b[2J": "c\r\nd\0e{}{0}%s"}).encode()
    yield "lines in the machine", changed(machine={**good["machine"], "em\nbree": "3\n\x1b[2J{}"}).encode()
    yield "twice the same", head[:-2] + b',"bits":1,"bits":2,"settings":{}}'
    yield "a long text", changed(settings={"spp": "x" * 1000000}).encode()
    yield "a long name", changed(settings={"x" * 1000000: "1"}).encode()
    yield "many members", ("{" + ",".join(f'"{i:x}":1' for i in range(90000)) + "}").encode()
    yield "many settings", json.dumps({**good, "settings": {f"{i:x}": 1 for i in range(80000)}}).encode()[: 1 << 20]
    yield "all spaces", b" " * (1 << 20)
    yield "a long number", b'{"bits":' + b"9" * 1000000 + b"}"
    yield "a huge exponent", b'{"bits":1e999999999999}'


def starts(head, tail):
    """Yields the contents of files with odd first bytes, each with the name of its case."""
    yield "format 0", file_start(head, form=0) + tail
    yield "format 2^32-1", file_start(head, form=(1 << 32) - 1) + tail
    yield "a head of 2^32-1 bytes", file_start(head, size=(1 << 32) - 1) + tail
    yield "a head of no bytes", file_start(b"") + tail
    yield "a head of 17 MiB", file_start(head + b" " * (17 << 20)) + tail
    yield "an empty file", b""
    yield "zeros", bytes(10000)
    yield "the mark alone", b"EMBRECF\n"


def odd_records(state):
    """Yields lists of records that the program would never write, each with the name of its case."""
    max_uint64 = (1 << 64) - 1
    for size in (0, 1, len(state) - 1, len(state) + 1, 1 << 20, 1 << 30, 1 << 32, 1 << 36, (1 << 36) + 1, 1 << 63, max_uint64):
        for kind, end in ((TILE, []), (BLOCK, [Record(END, 1, b"")])):
            yield f"kind {kind} that says {size} bytes", [Record(kind, 0, state, size=size), *end]
            yield f"kind {kind} that says {size} bytes, zstd too", [
                Record(kind, 0, b"", size=size, packed=records.stored(state, size)), *end]
    for packed in (b"", b"\0", b"\x28\xb5\x2f\xfd", bytes(1000), b"\xff" * 1000):
        yield f"no zstd {packed[:4].hex()} {len(packed)}", [Record(TILE, 0, state, packed=packed),
                                                             Record(BLOCK, 0, state, packed=packed), Record(END, 1, b"")]
    for number in (4, 5, 1 << 31, 1 << 32, max_uint64):
        yield f"tile {number}", [Record(TILE, number, state)]
    for number in (1, 2, 1 << 32, max_uint64):
        yield f"block {number}", [Record(BLOCK, number, state), Record(END, 1, b"")]
        yield f"end {number}", [Record(BLOCK, 0, state), Record(END, number + 1, b"")]
    for kind in (0, 4, (1 << 32) - 1):
        yield f"kind {kind}", [Record(kind, 0, state), Record(END, 1, b"")]
    yield "no blocks", [Record(END, 0, b"")]
    yield "a large end", [Record(BLOCK, 0, state), Record(END, 1, b"x" * 1000, size=1 << 40)]
    yield "two ends", [Record(BLOCK, 0, state), Record(END, 1, b""), Record(END, 2, b"")]
    yield "twice the state", [Record(BLOCK, 0, state), Record(BLOCK, 1, state), Record(END, 2, b"")]
    yield "many empty blocks", [*(Record(BLOCK, i, b"") for i in range(5000)), Record(END, 5000, b"")]
    yield "a zero tile thousands of times", [Record(TILE, 0, b"")] * 5000
    yield "one byte", [Record(TILE, 0, b"\0"), Record(TILE, 1, b"\xff")]
    yield "zeros", [Record(BLOCK, 0, bytes(len(state))), Record(END, 1, b"")]
    yield "ones", [Record(BLOCK, 0, b"\xff" * len(state)), Record(END, 1, b"")]


def mutated(state, dice):
    """Returns the state with some bytes or numbers changed, and occasionally with another length."""
    state = bytearray(state)
    for _ in range(dice.choice((1, 1, 1, 2, 8))):
        kind, at = dice.randrange(8), dice.randrange(len(state))
        if dice.random() < 0.5:  # aims at the end, which contains the driver's state and counters
            at = max(0, len(state) - 1 - dice.randrange(min(len(state), 1200)))
        if kind == 0:
            state[at] ^= 1 << dice.randrange(8)
        elif kind == 1:
            state[at] = dice.choice((0, 1, 2, 127, 128, 255))
        elif kind == 2:
            at = at // 4 * 4
            state[at : at + 4] = dice.choice((NAN, INFINITY, b"\xff" * 4, bytes(4), struct.pack("<f", -1),
                                              struct.pack("<f", 3e38), struct.pack("<I", 1 << 25),
                                              struct.pack("<I", 1 << 24), struct.pack("<I", dice.randrange(64))))
        elif kind in (3, 4):
            at = at // 8 * 8
            state[at : at + 8] = dice.choice((struct.pack("<d", float("nan")), struct.pack("<d", float("inf")),
                                              struct.pack("<d", 1e18), struct.pack("<d", -1.0), struct.pack("<d", 1e-300),
                                              struct.pack("<Q", (1 << 64) - 1), struct.pack("<Q", 1 << 63),
                                              struct.pack("<Q", (1 << 63) - 1), struct.pack("<Q", (1 << 31) - 1),
                                              struct.pack("<Q", dice.randrange(300)), struct.pack("<Q", dice.randrange(9))))
        elif kind == 5:
            length = dice.choice((4, 8, 16, 64, 300))
            other = dice.randrange(len(state))
            state[at : at + length] = state[other : other + length]
        elif kind == 6 and dice.random() < 0.3:
            del state[at : at + dice.choice((1, 4, 8, 100))]
        elif kind == 7:
            length = dice.choice((4, 16, 64, 500))
            state[at : at + length] = dice.randbytes(min(length, len(state) - at))
    return bytes(state)


class Hostile:
    def __init__(self, farm, name, zstd):
        self.farm, self.name, self.tiles = farm, name, name.startswith("bucket")
        self.settings = [*FRAME, "--driver", name.split()[0], *SETTINGS[name]]
        self.expected, _ = farm.reference(self.settings)
        folder = farm.folder(f"{name} saved")
        limit = ["--time-limit", "0.015"] if name.endswith("stopped") else []
        farm.run(folder, [*self.settings, "--resume", "--checkpoint", CHECKPOINT, "--resumable", *limit])
        self.head, self.records = records.parsed_file((folder / CHECKPOINT).read_bytes(), zstd)
        self.folder = farm.folder(f"{name} hostile")
        self.counts = {"done, right bits": 0, "done, other bits": 0, "refused": 0}

    def state(self):
        if self.tiles:
            return self.records[0].data
        return b"".join(record.data for record in self.records)

    def mutation(self, dice):
        """Returns the bytes of a checkpoint with a mutated state."""
        if self.tiles:
            changed = [Record(TILE, record.number, record.data) for record in self.records]
            chosen = dice.choice(changed)
            chosen.data = mutated(chosen.data, dice)
        else:
            changed = [Record(BLOCK, 0, mutated(self.state(), dice)), Record(END, 1, b"")]
        return packed_file(self.head, changed)

    def resume_from(self, case, data, right=False):
        """Resumes from a checkpoint with this data. If `right`, a run that finishes must have the right bits."""
        case = f"{self.name}: {case}"
        if not self.farm.is_selected(case):
            return
        for path in self.folder.iterdir():
            path.unlink()
        (self.folder / CHECKPOINT).write_bytes(data)
        before, largest = contents(self.folder), largest_child()
        run = self.farm.run(self.folder, [*self.settings, "--resume", "--checkpoint", CHECKPOINT], timeout=SECONDS,
                            limit=ADDRESSES)
        replay = f"--driver '{self.name}' --only '{case}'"
        if self.name.endswith("stopped"):
            saved = self.farm.root / (case.replace(" ", "_").replace(":", "") + ".checkpoint")
            saved.write_bytes(data)
            replay = f"--driver '{self.name}' --file {saved}"
        failed = len(self.farm.failures)
        self.check_run(case, replay, before, largest, run, right)
        if self.name.endswith("stopped"):
            if len(self.farm.failures) > failed:
                self.farm.options.keep = True
            else:
                saved.unlink()

    def check_run(self, case, replay, before, largest, run, right):
        check = self.farm.check
        if not check(not run.hung and run.code in (EXIT_DONE, EXIT_RENDER_FAILED, EXIT_INPUT), case,
                     f"should refuse or finish: {run}", replay):
            return
        now = largest_child()
        check(now <= max(largest, MEMORY), case, f"used {now >> 20} MiB: {run}", replay)
        check(len(run.err) < LONGEST_LINE, case, f"{len(run.err)} characters on stderr", replay)
        if run.code == EXIT_DONE:
            output = self.folder / "out.exr"
            if not check(output.exists(), case, f"no picture: {run}", replay):
                return
            same = pixels(output) == self.expected
            check(same or not right, case, "the picture's bits differ", replay)
            self.counts["done, right bits" if same else "done, other bits"] += 1
        else:
            self.farm.check_refused(run, self.folder, before, case, {EXIT_INPUT}, [CHECKPOINT], replay)
            self.counts["refused"] += 1


def main():
    farm = Farm(__doc__, driver=("", "run only the checkpoints of this name"),
                mutations=(60, "number of mutations of each state [60]"), seed=(1, "seed of the mutations [1]"),
                brief=(False, "run only the mutations"), file=("", "only resume from this file"))
    options = farm.options
    zstd = records.zstd_of(farm.program)
    if not zstd:
        farm.skip("all", "libzstd, which reads checkpoints, was not found")
        farm.check(True, "", "")
        farm.done()
    chosen = {name: Hostile(farm, name, zstd) for name in SETTINGS if name.startswith(options.driver)}
    if options.file:
        next(iter(chosen.values())).resume_from("file", pathlib.Path(options.file).read_bytes())
        farm.done()
    for name, hostile in chosen.items():
        again = [Record(record.kind, record.number, record.data) for record in hostile.records]
        hostile.resume_from("packed again", packed_file(hostile.head, again), right=True)
        for number in range(options.mutations):
            dice = random.Random(f"{options.seed} {name} {number}")
            hostile.resume_from(f"mutation {number}", hostile.mutation(dice))
        if name not in DRIVERS or options.brief:
            continue
        for text, found in odd_records(hostile.state()):
            hostile.resume_from(f"record, {text}", packed_file(hostile.head, found))
        for other in chosen.values():
            if other is not hostile:
                hostile.resume_from(f"state of {other.name}", packed_file(hostile.head, other.records))
        if name == "bucket" or LONG:  # headers are read before the driver matters
            for text, head in heads(hostile.head):
                hostile.resume_from(f"head, {text}", packed_file(head, again), right=True)
            for text, data in starts(hostile.head, b"".join(record.to_bytes() for record in again)):
                hostile.resume_from(f"start, {text}", data, right=True)
    for name, hostile in chosen.items():
        print(f"{name}: " + ", ".join(f"{count} {what}" for what, count in hostile.counts.items()))
    farm.done()


main()
