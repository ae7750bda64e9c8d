"""A frame that SIGTERM, SIGINT or --time-limit stops and that is then resumed has the bits of a frame that was left
alone. SIGUSR1 saves the checkpoint immediately, and the frame continues.

For every driver, this test checks the exit code of the stopped run, its checkpoint, and the picture's bits after
resuming. To run one case, give its name or a part of its name:

  stops.py build/release/bin/emberline scenes --only 'bucket SIGTERM'
"""

import os
import time

from farm import (CHANNELS, DRIVERS, EXIT_DONE, EXIT_STOPPED, LONG, Farm, earlier_samples, pixels, report_of, signal)

FRAME = ["--size", "128x96", "--bucket-size", "16", "--threads", "2", *CHANNELS]
SECONDS = 1.0 if LONG else 0.5  # on any machine, a frame takes each of its two threads this long
CHECKPOINT = "out.exr.checkpoint"
RESUME = ["--resume", "--checkpoint-interval", "100000", "--report", "report.json"]


def settings_of(farm, driver):
    settings = [*FRAME, "--driver", driver]
    return [*settings, "--spp", str(farm.samples_for(SECONDS, settings))]


def finish(farm, case, folder, settings, expected, carried=True):
    """Resumes a stopped frame and runs it to its end."""
    run = farm.run(folder, [*settings, *RESUME])
    if farm.check_done(run, folder, expected, case, {"report.json"}) and carried:
        farm.check(earlier_samples(folder) > 0, case, "no samples were carried over")


def stopped(farm, driver, name, stop):
    """Stops a run in mid-frame. `stop` is a function that stops a process, or a list of settings that stop the run."""
    case = f"{driver} {name}"
    if not farm.is_selected(case):
        return
    settings, folder = settings_of(farm, driver), farm.folder(case)
    expected, _ = farm.reference(settings)
    if callable(stop):
        process = farm.start(folder, [*settings, *RESUME])
        process.wait_until((folder / CHECKPOINT).exists)
        process.work(2 * 0.4 * SECONDS)
        stop(process)
        run = process.wait()
        farm.check(run.code == EXIT_STOPPED, case, f"should end with exit 130: {run}")
    else:
        run = farm.run(folder, [*settings, *RESUME, *stop])
        farm.check(run.code == EXIT_STOPPED, case, f"should end with exit 130, as there is more to do: {run}")
    farm.check((folder / CHECKPOINT).exists(), case, f"no checkpoint is left: {run}")
    if (folder / "out.exr").exists():
        farm.check(pixels(folder / "out.exr") != expected, case,
                   "the stop came too late: the picture is already finished")
    finish(farm, case, folder, settings, expected)


def once(number):
    return lambda process: process.signal(number)


def twice(number):
    """Returns a function that sends two signals. The second signal ends the process immediately, and unsaved work is
    lost."""

    def stop(process):
        process.signal(number)
        time.sleep(0.002)
        process.signal(number)

    return stop


def stopped_twice(farm, driver):
    """Sends two stop signals in a row, at the start or in mid-frame. The next run must always have the right bits."""
    settings = settings_of(farm, driver)
    # Each moment is (pause, share, signal). If share is not 0, the test waits for the first save of the checkpoint.
    # Then it waits for `pause` seconds, and for work that takes `share` of SECONDS.
    moments = [(0, 0.15, signal.SIGINT), (0.02, 0, signal.SIGTERM), (0, 0.05, signal.SIGTERM), (0.05, 0, signal.SIGINT)]
    for i, (pause, share, number) in enumerate(moments if LONG else moments[:2]):
        case = f"{driver} stopped twice {i}"
        if not farm.is_selected(case):
            continue
        expected, _ = farm.reference(settings)
        folder = farm.folder(case)
        process = farm.start(folder, [*settings, *RESUME])
        if share:
            process.wait_until((folder / CHECKPOINT).exists)
        time.sleep(pause)
        process.work(2 * share * SECONDS)
        twice(number)(process)
        run = process.wait()
        # A signal that arrives before the program has installed its handlers kills the program.
        farm.check(run.code in (EXIT_STOPPED, -number), case, f"should end with exit 130: {run}")
        finish(farm, case, folder, settings, expected, carried=False)


def stopped_repeatedly(farm, driver):
    """Stops a frame repeatedly by time limits that are a fraction of its duration, each time with another number of
    threads. The limits grow, because under other load a run may make no progress within a short limit."""
    case = f"{driver} again and again"
    if not farm.is_selected(case):
        return
    settings, folder = settings_of(farm, driver), farm.folder(case)
    expected, seconds = farm.reference(settings)
    earlier = -1
    for i in range(40):
        limit = ["--time-limit", f"{min(seconds, 2 * SECONDS) / 5 * 1.2**i:.3f}"]
        run = farm.run(folder, [*settings, *RESUME, *limit, "--threads", str(1 + i % 2)])
        left = (folder / CHECKPOINT).exists()
        if not farm.check(run.code == (EXIT_STOPPED if left else EXIT_DONE), case, f"run {i}: {run}"):
            return
        if not left:
            break
        now = earlier_samples(folder)
        farm.check(now >= earlier, case, f"run {i} began with {now} samples, the one before with {earlier}")
        earlier = now
    farm.check(i > 1, case, "it was never stopped")
    farm.check_done(run, folder, expected, case, {"report.json"})


def saved_on_request(farm, driver):
    """Checks that SIGUSR1 in mid-frame saves a checkpoint, from which the next run resumes if the run is then killed.
    Many such signals must do no harm."""
    settings = settings_of(farm, driver)
    case = f"{driver} SIGUSR1"
    if not farm.is_selected(case):
        return
    expected, _ = farm.reference(settings)
    folder = farm.folder(case)
    process = farm.start(folder, [*settings, *RESUME])
    file = folder / CHECKPOINT
    process.wait_until(file.exists)
    process.work(2 * 0.3 * SECONDS)
    before = file.stat()
    process.signal(signal.SIGUSR1)

    def is_rewritten():
        now = file.stat()
        return now.st_mtime_ns != before.st_mtime_ns and now.st_size > before.st_size

    farm.check(process.wait_until(is_rewritten), case, "the checkpoint was not rewritten")
    farm.check(process.running(), case, "the run did not continue")
    process.signal(signal.SIGKILL)
    process.wait()
    finish(farm, case, folder, settings, expected)

    process = farm.start(folder, [*settings, *RESUME])
    process.wait_until(file.exists)
    time.sleep(0.05)
    while process.running():
        process.signal(signal.SIGUSR1)
        time.sleep(0.02)
    run = process.wait()
    if farm.check_done(run, folder, expected, case + " storm", {"report.json"}):
        written = report_of(folder)["checkpoint"]["written"]
        farm.check(written > 1, case + " storm", f"only {written} checkpoints were written")


def without_checkpoint(farm, driver):
    case = f"{driver} SIGUSR1 without a checkpoint"
    if not farm.is_selected(case):
        return
    settings, folder = settings_of(farm, driver), farm.folder(case)
    expected, _ = farm.reference(settings)
    process = farm.start(folder, settings)
    process.wait_until(lambda: any(folder.iterdir()))  # once outputs are open, the signal handlers are installed
    while process.running():
        process.signal(signal.SIGUSR1)
        time.sleep(0.05)
    farm.check_done(process.wait(), folder, expected, case)


def ignored_on_start(farm):
    """Checks that a signal does not end the program before it has read the scene, once it handles the signal."""
    case = "SIGUSR1 while it starts"
    if not farm.is_selected(case):
        return
    settings = ["--size", "16x12", "--spp", "1", "--threads", "1", *CHANNELS]
    expected, _ = farm.reference(settings)
    for i in range(20):
        folder = farm.folder(case)
        process = farm.start(folder, [*settings, "--resume"])

        def is_handled():
            with open(f"/proc/{process.process.pid}/status") as status:
                mask = next((line for line in status if line.startswith("SigCgt")), "SigCgt: 0")
            return int(mask.split()[1], 16) >> (signal.SIGUSR1 - 1) & 1

        if process.wait_until(lambda: process.running() and is_handled()):
            os.kill(process.process.pid, signal.SIGUSR1)
        farm.check_done(process.wait(), folder, expected, case)


def main():
    farm = Farm(__doc__, driver=("", "run only this driver"))
    for driver in [farm.options.driver] if farm.options.driver else DRIVERS:
        stopped(farm, driver, "SIGTERM", once(signal.SIGTERM))
        if LONG or driver == "bucket":  # one driver is enough, because drivers do not know why they are stopped
            stopped(farm, driver, "SIGINT", once(signal.SIGINT))
            stopped(farm, driver, "--time-limit", ["--time-limit", str(0.4 * SECONDS)])
            without_checkpoint(farm, driver)
        stopped_twice(farm, driver)
        stopped_repeatedly(farm, driver)
        saved_on_request(farm, driver)
        if driver == "bucket":
            ignored_on_start(farm)
    farm.done()


main()
