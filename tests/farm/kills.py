"""A frame that is killed (SIGKILL) and resumed repeatedly has the same bits as a frame that was left alone.

This test kills each frame a few times at random moments: while the program starts, while it renders, and while it
writes its outputs. Then the frame runs to its end. Between kills, the number of threads and the order of the buckets
change. An output that exists after a kill must have the right bits. At the end, the folder may contain only the
outputs.

To repeat one frame with its kills (its number is in the failure's message):

  kills.py build/release/bin/emberline scenes --driver bucket --seed 1 --frame 3

The random numbers depend on the seed, the driver and the frame; the exact moment of a kill depends on the machine.
"""

import random
import shutil
import time

from farm import CHANNELS, DRIVERS, EXIT_DONE, LONG, Farm, earlier_samples, pixels, signal

# These sizes take long enough that most kills come after the first save of a checkpoint.
FRAME = ["--size", "192x144" if LONG else "144x108", *CHANNELS]
SETTINGS = {
    "bucket": ("--spp 64", "--noise-threshold 0.04 --max-spp 256", "--spp 48 --streams 2", "--spp 48 --light-groups",
               "--spp 64 --sampler stratified --crop 7,5,122,90"),
    "bisection": ("--spp 64", "--spp 48 --light-groups", "--spp 48 --streams 2",
                  "--spp 64 --bisection-axis rows --sampler blue_noise"),
    "adaptive": ("--spp 64", "--spp 48 --unbiased", "--spp 48 --light-groups", "--spp 48 --streams 2",
                 "--noise-threshold 0.04 --max-spp 256", "--spp 48 --estimator two-stream --unbiased"),
}
ORDERS = ("hilbert", "spiral", "scanline", "random")
RESUME = ["--resume", "--checkpoint-interval", "0.1", "--bucket-size", "16", "--report", "report.json"]


def kill(farm, process, folder, moment, seconds, dice):
    """Kills the process at a moment of this kind. Returns the finished run."""
    if moment == "start":
        time.sleep(dice.uniform(0, 0.06))
    elif moment == "middle":
        process.work(2 * dice.uniform(0.1 + 0.1 * seconds, 0.1 + 0.5 * seconds))
    else:
        process.wait_until((folder / "out.exr").exists)
        time.sleep(dice.uniform(0, 0.004))
    process.signal(signal.SIGKILL)
    return process.wait()


def frame(farm, driver, number, most):
    """Kills one frame at most `most` times. Returns how many kills it tried, how many hit a running process, and
    whether the last run had samples from earlier runs (None if no earlier run had rendered)."""
    seed = farm.options.seed
    dice = random.Random(f"{seed} {driver} {number}")
    settings = [*FRAME, "--driver", driver, "--bucket-size", "16",
                *SETTINGS[driver][number % len(SETTINGS[driver])].split()]
    case = f"{driver} frame {number} ({' '.join(settings[6:])})"
    each = farm.options.each
    replay = f"--driver {driver} --seed {seed} --each {each} --frame {number}"
    expected, seconds = farm.reference([*settings, "--threads", "2"])
    folder = farm.folder(f"{driver} {number}")

    def start():
        changing = ["--threads", dice.choice("12")]
        if driver == "bucket":
            changing += ["--bucket-order", dice.choice(ORDERS)]
        return farm.start(folder, [*settings, *RESUME, *changing])

    tried = landed = in_middle = 0
    for _ in range(min(most, dice.randint((each + 1) // 2, each))):
        moment = dice.choices(("start", "middle", "outputs"), (2, 8, 1))[0]
        if (folder / "out.exr").exists():
            moment = "start"
        run = kill(farm, start(), folder, moment, seconds, dice)
        tried += 1
        landed += run.code == -signal.SIGKILL
        in_middle += run.code == -signal.SIGKILL and moment != "start"
        farm.check(run.code in (-signal.SIGKILL, EXIT_DONE), case, f"should be killed or finish: {run}", replay)
        if (folder / "out.exr").exists():
            farm.check(pixels(folder / "out.exr") == expected, case,
                       f"a kill ({moment}) left an output whose bits differ", replay)
        if run.code == EXIT_DONE:
            break
    # If a run finished before its kill, it left no checkpoint, so the next run starts from nothing.
    done = run.code == EXIT_DONE and earlier_samples(folder) > 0
    run = start().wait()
    ok = farm.check_done(run, folder, expected, case, {"report.json"}, replay)
    carried = done or earlier_samples(folder) > 0 if ok and in_middle else None
    if ok:
        shutil.rmtree(folder)
    return tried, landed, carried


def main():
    farm = Farm(__doc__, kills=(100, "total number of kills, shared by the drivers [100]"),
                each=(7, "maximum number of kills of one frame [7]"), seed=(1, "seed of the random choices [1]"),
                driver=("", "run only this driver"), frame=(-1, "run only the frame with this number"))
    options = farm.options
    drivers = [options.driver] if options.driver else DRIVERS
    if options.frame >= 0:
        frame(farm, drivers[0], options.frame, 100)
        farm.done()
    tried = landed = 0
    carried = []
    for i, driver in enumerate(drivers):
        end, number = options.kills * (i + 1) // len(drivers), 0
        while tried < end:
            more = frame(farm, driver, number, end - tried)
            tried, landed, number = tried + more[0], landed + more[1], number + 1
            carried += [more[2]] if more[2] is not None else []
    print(f"{tried} kills, {landed} hit a running process; {sum(carried)} of {len(carried)} frames resumed samples of "
          "earlier runs")
    farm.check(3 * landed >= 2 * tried, "kills", f"only {landed} of {tried} hit a running process", "")
    farm.check(2 * sum(carried) > len(carried), "kills",
               f"only {sum(carried)} of {len(carried)} frames resumed samples")
    farm.done()


main()
