"""If a disk fails while a checkpoint is written, the checkpoint is lost but not the frame: the run prints one warning,
exits with 0, and its picture has the right bits. What was saved before can be resumed. Two runs of one job never share
a checkpoint.

The checkpoint is in a separate folder, which fails in several ways. It is on a small file system that becomes full (if
mounting is allowed). Or calls fail, because broken_disk.c is loaded before the C library (if there is a compiler). Or
the folder is removed, moved or write-protected. To run one case, give its name or a part of its name:

  disk.py build/release/bin/emberline scenes --only 'full disk of bisection'
"""

import errno
import os
import pathlib
import shutil
import subprocess

from farm import (CHANNELS, DRIVERS, EXIT_DONE, EXIT_RENDER_FAILED, EXIT_USAGE, LONG, Farm, Process, contents,
                  earlier_samples, pixels, report_of, signal)

FRAME = ["--size", "96x72", "--bucket-size", "16", "--threads", "2", *CHANNELS]
# On any machine, a frame takes each of its two threads this long, which is five or seven checkpoint intervals.
SECONDS = 0.7 if LONG else 0.5
REPORT = ["--report", "report.json"]


def settings_of(farm, driver, seconds=SECONDS):
    settings = [*FRAME, "--driver", driver]
    return [*settings, "--spp", str(farm.samples_for(seconds, settings))]


def resume(file):
    return ["--resume", "--checkpoint", file, "--checkpoint-interval", "0.1", *REPORT]


def warnings(run):
    return [line for line in run.err.splitlines() if "warning" in line]


def check_warned(farm, run, folder, expected, case, file, stray=()):
    """Checks that the run finished the frame and printed one warning, which names the file."""
    farm.check_done(run, folder, expected, case, {"report.json", *stray})
    warning_lines = warnings(run)
    farm.check(len(warning_lines) == 1 and file in warning_lines[0], case, f"should warn once and name {file}: {run}")


def check_resumes(farm, driver, folder, file, expected, case):
    """Checks that the next run finishes, whether it resumes what the failing run left or starts from nothing."""
    run = farm.run(folder, [*settings_of(farm, driver), *resume(file)])
    farm.check_done(run, folder, expected, case + ", resumed", {"report.json"})


def failing_calls(farm, drivers):
    library = farm.root / "broken_disk.so"
    compiler = shutil.which("cc")
    source = pathlib.Path(__file__).with_name("broken_disk.c")
    if not compiler or subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"]).returncode:
        return farm.skip("failing calls", "no C compiler (cc) was found")
    if farm.options.driver in ("", "paths"):
        failing_products(farm, library)
    for driver in drivers:
        if driver == "bucket":
            kinds = ("fdatasync", "pwrite,ftruncate,half", "pwrite", "half,pwrite", "pwrite,ftruncate")
        else:
            kinds = ("rename", "half,pwrite", "fsync", "pwrite", "pwrite,fsync,rename")
        for calls in kinds if LONG else kinds[:2]:
            # The first few calls begin the file. After that, fsync, fdatasync and rename are called only a few times a
            # second.
            few = calls in ("fsync", "fdatasync", "rename")
            failures = ((errno.EIO, 2 if few else 4), (errno.ENOSPC, 3 if few else 7))
            for error, after in failures if LONG or calls == kinds[0] else failures[:1]:
                case = f"{driver}: {calls} fails with {errno.errorcode[error]} after {after} calls"
                if not farm.is_selected(case):
                    continue
                expected, _ = farm.reference(settings_of(farm, driver))
                folder = farm.folder(case)
                (folder / "kept").mkdir()
                broken = {"LD_PRELOAD": str(library), "BROKEN_PATH": "/kept/", "BROKEN_CALLS": calls,
                          "BROKEN_ERROR": str(error), "BROKEN_AFTER": str(after),
                          "ASAN_OPTIONS": os.environ.get("ASAN_OPTIONS", "") + ":verify_asan_link_order=0"}
                run = farm.run(folder, [*settings_of(farm, driver), *resume("kept/c")], environment=broken)
                check_warned(farm, run, folder, expected, case, "kept/c")
                if error != errno.EIO:
                    continue
                # If such a run is killed before its end, the next run must be able to use what the broken disk kept.
                folder = farm.folder(case)
                (folder / "kept").mkdir()
                process = farm.start(folder, [*settings_of(farm, driver), *resume("kept/c")], environment=broken)
                process.wait_until((folder / "kept/c").exists)
                process.work(2 * 0.6 * SECONDS)
                process.signal(signal.SIGKILL)
                process.wait()
                check_resumes(farm, driver, folder, "kept/c", expected, case)


def failing_products(farm, library):
    """If the checkpoint is the result of the run, a failing disk must make the run fail. Existing files must stay
    unchanged."""
    def broken(path, calls, after):
        return {"LD_PRELOAD": str(library), "BROKEN_PATH": path, "BROKEN_CALLS": calls, "BROKEN_AFTER": str(after),
                "ASAN_OPTIONS": os.environ.get("ASAN_OPTIONS", "") + ":verify_asan_link_order=0"}

    settings = [*FRAME, "--spp", "8"]
    for calls, after in (("pwrite", 4), ("fdatasync", 0)):
        case = f"a part whose {calls} fails"
        if farm.is_selected(case):
            folder = farm.folder(case)
            run = farm.run(folder, [*settings, "--part", "1/2"], environment=broken(".part-1-of-2", calls, after))
            # A failed save during the frame causes a warning. If the frame ends before the first save, there is no
            # warning.
            farm.check(run.code == EXIT_RENDER_FAILED and len(warnings(run)) <= 1 and
                       "has this part" not in run.err, case, f"should fail: {run}")
            shutil.rmtree(folder)
            folder = farm.folder(case)
            run = farm.run(folder, [*settings, "--part", "1/2", "--quiet"],
                           environment=broken(".part-1-of-2", calls, after))
            farm.check(run.code == EXIT_RENDER_FAILED and len(run.err.splitlines()) == 1, case,
                       f"should fail with one line: {run}")
    for driver, calls, after in (("bucket", "pwrite", 4), ("bisection", "pwrite", 2), ("bisection", "rename", 0)):
        case = f"an extended frame of {driver} whose {calls} fails"
        if not farm.is_selected(case):
            continue
        begun = [*FRAME, "--driver", driver, "--resumable", "--spp"]
        expected, _ = farm.reference([*begun[:-2], "--spp", "96"])
        folder = farm.folder(case)
        farm.run(folder, [*begun, "4"])
        before = contents(folder)["out.exr.checkpoint"]
        words = [farm.program, "extend", "out.exr", "--spp", "96"]
        run = Process(words, folder, broken("/out.exr.checkpoint.next", calls, after)).wait()
        farm.check(run.code == EXIT_RENDER_FAILED and len(warnings(run)) <= 1 and "out.exr.checkpoint.next" in run.err,
                   case, f"should fail: {run}")
        farm.check(contents(folder).get("out.exr.checkpoint") == before, case, "the existing checkpoint has changed")
        run = Process(words, folder).wait()
        farm.check_done(run, folder, expected, case, {"out.exr.checkpoint"})


def lost_picture(farm, driver):
    """If the run cannot write the picture at the end, the checkpoint must contain the whole frame."""
    case = f"lost picture of {driver}"
    if not farm.is_selected(case):
        return
    folder = farm.folder(case)
    (folder / "pictures").mkdir()
    command = [*settings_of(farm, driver), "--resume", "--checkpoint", "c", *REPORT]
    process = farm.start(folder, command, output="pictures/out.exr")
    process.wait_until((folder / "c").exists)
    shutil.rmtree(folder / "pictures")
    run = process.wait()
    farm.check(run.code == EXIT_RENDER_FAILED, case, f"should fail: {run}")
    (folder / "pictures").mkdir()
    run = farm.run(folder, command, output="pictures/out.exr")
    total = report_of(folder)["samples"]["total"]
    farm.check(run.code == EXIT_DONE and earlier_samples(folder) == total, case,
               f"should only write the picture, without rendering: {run}")
    farm.check(pixels(folder / "pictures/out.exr") == farm.reference(settings_of(farm, driver))[0], case,
               "the picture's bits differ")


def full_disk(farm, driver):
    """On a file system of 64 KiB, a run can begin the checkpoint, but soon there is no space."""
    case = f"full disk of {driver}"
    if not farm.is_selected(case):
        return
    expected, _ = farm.reference(settings_of(farm, driver))
    folder, disk = farm.folder(case), farm.folder("full disk")
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", disk]
    if os.geteuid() or subprocess.run(mount, capture_output=True).returncode:
        return farm.skip(case, "mounting is not allowed")
    try:
        run = farm.run(folder, [*settings_of(farm, driver), *resume(str(disk / "c"))])
        check_warned(farm, run, folder, expected, case, "c")
        farm.check(not contents(disk), case, f"files left on the full disk: {contents(disk)}")
        process = farm.start(folder, [*settings_of(farm, driver), *resume(str(disk / "c"))])
        process.work(1.0)
        process.signal(signal.SIGKILL)
        process.wait()
        check_resumes(farm, driver, folder, str(disk / "c"), expected, case)
        (disk / "full").write_bytes(bytes(64 << 10))
        run = farm.run(folder, [*settings_of(farm, driver), *resume(str(disk / "c")), "--quiet"])
        farm.check(run.code == EXIT_RENDER_FAILED and len(run.err.splitlines()) == 1, case + " from the start",
                   f"should fail before it renders if the checkpoint cannot be started: {run}")
    finally:
        subprocess.run(["umount", disk], check=True)


def lost_folder(farm, driver, what, damage, back):
    """`damage` makes the folder unusable in mid-frame, and `back` restores it after the run."""
    case = f"{what} of {driver}"
    if not farm.is_selected(case):
        return
    expected, _ = farm.reference(settings_of(farm, driver))
    folder = farm.folder(case)
    kept = folder / "kept"
    kept.mkdir()
    process = farm.start(folder, [*settings_of(farm, driver), *resume("kept/c")])
    process.wait_until((kept / "c").exists)
    process.work(2 * 0.3 * SECONDS)
    damage(kept)
    run = process.wait()
    back(kept)
    stray = {name for name in contents(folder) if name.startswith("moved/")}
    farm.check_done(run, folder, expected, case, {"report.json", *stray})
    warning_lines = warnings(run)
    # The bucket driver appends to an open file, which works even after the file was moved or removed.
    min_warnings = 0 if driver == "bucket" else 1
    farm.check(min_warnings <= len(warning_lines) <= 1, case, f"should warn {min_warnings} times: {run}")


def lost_folders(farm, driver):
    def remove(kept):
        while kept.exists():  # the run may create new files during the removal
            shutil.rmtree(kept, ignore_errors=True)

    lost_folder(farm, driver, "removed folder", remove, lambda kept: None)
    lost_folder(farm, driver, "moved folder", lambda kept: kept.rename(kept.with_name("moved")), lambda kept: None)
    # Another folder appears under the old name, with a file that the run must not touch.
    def replace(kept):
        kept.rename(kept.with_name("moved"))
        kept.mkdir()
        (kept / "other").write_text("mine")

    case = f"replaced folder of {driver}"
    if farm.is_selected(case):
        expected, _ = farm.reference(settings_of(farm, driver))
        folder = farm.folder(case)
        (folder / "kept").mkdir()
        process = farm.start(folder, [*settings_of(farm, driver), *resume("kept/c")])
        process.wait_until((folder / "kept" / "c").exists)
        process.work(2 * 0.3 * SECONDS)
        replace(folder / "kept")
        run = process.wait()
        stray = {name for name in contents(folder) if name.startswith("moved/")}
        farm.check_done(run, folder, expected, case, {"report.json", "kept/other", *stray})
        farm.check((folder / "kept/other").read_text() == "mine", case, "the other file has changed")
    case = f"replaced file of {driver}"
    if driver == "bucket" and farm.is_selected(case):
        expected, _ = farm.reference(settings_of(farm, driver))
        folder = farm.folder(case)
        (folder / "kept").mkdir()
        process = farm.start(folder, [*settings_of(farm, driver), *resume("kept/c")])
        process.wait_until((folder / "kept" / "c").exists)
        (folder / "kept/mine").write_text("mine")
        (folder / "kept/mine").rename(folder / "kept/c")
        run = process.wait()
        farm.check(run.code == EXIT_DONE and (folder / "kept/c").exists() and
                   (folder / "kept/c").read_text() == "mine", case, f"the other file is gone or has changed: {run}")
    if os.geteuid() == 0:
        return farm.skip(f"write-protected folder of {driver}", "root can write everywhere")
    lost_folder(farm, driver, "write-protected folder", lambda kept: kept.chmod(0o500), lambda kept: kept.chmod(0o700))


def concurrent_runs(farm, driver):
    """While a run uses a checkpoint, a second run of the same job must refuse, without disturbing the first run."""
    case = f"twice at once of {driver}"
    if not farm.is_selected(case):
        return
    expected, _ = farm.reference(settings_of(farm, driver))
    folder = farm.folder(case)
    command = [*settings_of(farm, driver), *resume("c")]
    first = farm.start(folder, command)
    first.wait_until((folder / "c").exists)
    first.work(2 * 0.2 * SECONDS)
    first.signal(signal.SIGSTOP)  # otherwise it might end too soon on a slow machine
    farm.check(first.running(), case, "the first run has already ended")
    for _ in range(3):
        second = farm.run(folder, [*command, "--quiet"])
        farm.check(second.code == EXIT_RENDER_FAILED and len(second.err.splitlines()) == 1 and
                   second.err.startswith("emberline: error: ") and "c: another run is using it" in second.err, case,
                   f"the second run should refuse: {second}")
    # Without --resume, the second run would start a new checkpoint, but it must refuse, too.
    second = farm.run(folder, [*settings_of(farm, driver), "--checkpoint", "c", "--quiet"])
    farm.check(second.code == EXIT_RENDER_FAILED and "another run is using it" in second.err, case,
               f"the second run should refuse even without --resume: {second}")
    first.signal(signal.SIGCONT)
    farm.check_done(first.wait(), folder, expected, case, {"report.json"})


def simultaneous_starts(farm, driver):
    case = f"same moment of {driver}"
    if not farm.is_selected(case):
        return
    settings = settings_of(farm, driver, SECONDS / 2)  # half the work, because each run has only one thread
    expected, _ = farm.reference(settings)
    both = 0
    times = 4 if LONG else 2
    for _ in range(times):
        folder = farm.folder(case)
        command = [*settings, *resume("c"), "--quiet", "--threads", "1"]
        runs = [run.wait() for run in [farm.start(folder, command), farm.start(folder, command)]]
        codes = sorted(run.code for run in runs)
        farm.check(codes in ([0, 0], [0, 1]), case, f"{runs[0]} | {runs[1]}")
        both += codes == [0, 0]
        farm.check(pixels(folder / "out.exr") == expected, case, "the picture's bits differ")
        farm.check(set(contents(folder)) <= {"out.exr", "report.json"}, case, f"stray files: {contents(folder).keys()}")
    farm.check(both == 0, case, f"in {both} of {times} tries neither run refused: both used the checkpoint")


def unusable_paths(farm):
    """If a checkpoint cannot have the given name, the run prints one line, exits with 1 or 2, and writes nothing."""
    small = ["--size", "16x12", "--spp", "1", "--threads", "1", "--quiet"]
    for resumed in (["--resume"], []):
        for what, path in (("a folder", "folder"), ("a folder with a slash", "folder/"), ("no folder", "absent/c"),
                           ("a device", "/dev/null"), ("a full device", "/dev/full"), ("a pipe", "pipe"), ("stdout", "/dev/stdout"),
                           ("the output", "out.exr"), ("the output by another name", "./folder/../out.exr"),
                           ("the output by a link", "link"), ("the report", "report.json"), ("the scene", "scene.glb"),
                           ("a link to the scene", "scene link"), ("the environment", "env.hdr"), ("nothing", ""),
                           ("a long name", "x" * 300), ("below a file", "scene.glb/c"), ("a loop of links", "loop"),
                           ("write-protected", "protected")):
            case = f"checkpoint that is {what}{'' if resumed else ', not resumed'}"
            if not farm.is_selected(case):
                continue
            if what == "write-protected" and os.geteuid() == 0:
                farm.skip(case, "root can write everywhere")
                continue
            folder = farm.folder(case)
            (folder / "folder").mkdir()
            os.mkfifo(folder / "pipe")
            (folder / "link").symlink_to("out.exr")
            (folder / "loop").symlink_to("loop")
            shutil.copy(farm.scene(), folder / "scene.glb")
            (folder / "scene link").symlink_to("scene.glb")
            shutil.copy(farm.scenes / "dusk.hdr", folder / "env.hdr")
            (folder / "protected").write_text("x")
            (folder / "protected").chmod(0o400)
            before = contents(folder)
            env = ["--env", "env.hdr"] if "environment" in what else []
            run = farm.run(folder, [*small, *REPORT, *env, *resumed, "--checkpoint", path], scene="scene.glb",
                           timeout=10)
            if what == "nothing" and run.code == EXIT_DONE:  # an empty name means that no name is given
                continue
            farm.check_refused(run, folder, before, case, {EXIT_RENDER_FAILED, EXIT_USAGE})


def main():
    farm = Farm(__doc__, driver=("", "run only this driver, or `paths`: names that a checkpoint cannot have"))
    drivers = [driver for driver in DRIVERS if driver.startswith(farm.options.driver)]
    if farm.options.driver in ("", "paths"):
        unusable_paths(farm)
    for driver in drivers:
        full_disk(farm, driver)
        lost_picture(farm, driver)
        concurrent_runs(farm, driver)
        simultaneous_starts(farm, driver)
        lost_folders(farm, driver)
    failing_calls(farm, drivers)
    farm.done()


main()
