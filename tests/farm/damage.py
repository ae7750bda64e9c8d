"""If a checkpoint is truncated or corrupted, the program refuses it, or the frame still has the right bits. The program
never crashes, hangs or shows another picture.

For each driver, this test uses a checkpoint of a few kilobytes, from a small frame. It cuts the file to many lengths,
and flips single bits at random places. To refuse means: exit with 3, print one line that names the file, write nothing,
and leave the file unchanged. The lengths include all lengths within the file's header and within each record's header,
one byte more or less than each section, and every --stride-th other length (all: --stride 1). To repeat one case, use
its options as the failure prints them:

  damage.py build/release/bin/emberline scenes --driver bucket --length 700
  damage.py build/release/bin/emberline scenes --driver bucket --bit 5601
"""

import random

import records
from farm import CHANNELS, DRIVERS, EXIT_INPUT, SANITIZED, Farm, contents, pixels

FRAME = ["--size", "16x12", "--bucket-size", "8", "--spp", "4", "--threads", "1", "--quiet", *CHANNELS]
CHECKPOINT = "the.checkpoint"
RESUME = ["--resume", "--checkpoint", CHECKPOINT]
SECONDS = 600 if SANITIZED else 60  # limit on wall-clock time; it is long because machines may be busy


class Checkpoints:
    """The checkpoint of one driver, and its damaged copies."""

    def __init__(self, farm, driver):
        self.farm, self.driver = farm, driver
        self.settings = [*FRAME, "--driver", driver]
        self.expected, _ = farm.reference(self.settings)
        folder = farm.folder(f"{driver} saved")
        farm.run(folder, [*self.settings, *RESUME, "--resumable"])
        self.bytes = (folder / CHECKPOINT).read_bytes()
        self.folder = farm.folder(f"{driver} damaged")
        self.refused = self.done = 0

    def resume_from(self, data, case, replay):
        for path in self.folder.iterdir():
            path.unlink()
        (self.folder / CHECKPOINT).write_bytes(data)
        before = contents(self.folder)
        run = self.farm.run(self.folder, [*self.settings, *RESUME], timeout=SECONDS)
        if run.code == 0 and not run.hung:
            self.done += 1
            output = self.folder / "out.exr"
            self.farm.check(output.exists() and pixels(output) == self.expected, case,
                            f"the picture's bits differ: {run}", replay)
            self.farm.check(set(contents(self.folder)) == {"out.exr"}, case, "stray files", replay)
        else:
            self.refused += 1
            self.farm.check_refused(run, self.folder, before, case, {EXIT_INPUT}, [CHECKPOINT], replay)


def lengths(data, stride):
    """Returns the lengths to which a file is cut."""
    head, found = records.parsed_file(data)
    head_end = records.FILE_START + len(head)
    chosen = {*range(records.FILE_START + 2), *range(0, len(data), stride), head_end - 1, head_end}
    for record in found:
        begin = record.at
        chosen |= {*range(begin - 1, begin + records.RECORD_START + 2)}
        chosen |= {begin + records.RECORD_START + record.packed_size - 1}
    return sorted(length for length in chosen if 0 <= length < len(data))


def main():
    farm = Farm(__doc__, driver=("", "run only this driver"),
                flips=(200, "number of bits to flip for each driver [200]"),
                stride=(61, "step between the lengths to which a file is cut [61]"),
                seed=(1, "seed of the positions of the bits [1]"), length=(-1, "cut only to this length"),
                bit=(-1, "flip only this bit"))
    options = farm.options
    one = options.length >= 0 or options.bit >= 0
    for driver in [options.driver] if options.driver else DRIVERS:
        checkpoints = Checkpoints(farm, driver)
        data = checkpoints.bytes
        if not one:
            checkpoints.resume_from(data, f"{driver} whole", f"--driver {driver}")
            farm.check(checkpoints.done == 1, f"{driver} whole", "an intact checkpoint is refused")
        cuts = [options.length] if options.length >= 0 else [] if one else lengths(data, options.stride)
        for length in cuts:
            checkpoints.resume_from(data[:length], f"{driver} length {length}", f"--driver {driver} --length {length}")
        dice = random.Random(f"{options.seed} {driver}")
        bits = dice.sample(range(8 * len(data)), min(options.flips, 8 * len(data)))
        for bit in [options.bit] if options.bit >= 0 else [] if one else bits:
            damaged = bytearray(data)
            damaged[bit // 8] ^= 1 << bit % 8
            checkpoints.resume_from(bytes(damaged), f"{driver} bit {bit}", f"--driver {driver} --bit {bit}")
        print(f"{driver}: {len(data)} bytes, {len(cuts)} lengths, {0 if one else len(bits)} bits: {checkpoints.done} done, "
              f"{checkpoints.refused} refused")
    farm.done()


main()
