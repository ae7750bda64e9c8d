"""Shared code of the tests in tests/farm. It runs the program, hashes pictures and folders, and prints failures and how
to repeat them."""

import argparse
import hashlib
import json
import math
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "invariance"))
from frame_bits import chunks  # noqa: E402

# All channels whose bits are reproducible. The channel "time" is not.
CHANNELS = ["--aov", "variance,albedo,N,Z,velocity,id,stop"]
# A sanitized program starts and runs slowly. It also maps terabytes of memory that it never uses.
SANITIZED = bool(os.environ.get("EMBERLINE_SANITIZE"))
# ci/nightly.sh runs every case. ctest runs fewer cases, but enough of them to find a fault in any driver.
LONG = bool(os.environ.get("EMBERLINE_LONG_TESTS"))
DRIVERS = ("bucket", "bisection", "adaptive")
EXIT_DONE, EXIT_RENDER_FAILED, EXIT_USAGE, EXIT_INPUT, EXIT_STOPPED = 0, 1, 2, 3, 130


def pixels(path):
    """Returns a hash of the pixels of an EXR file. It does not depend on the header or the order of the tiles."""
    return hashlib.sha256(b"".join(chunks(pathlib.Path(path).read_bytes()))).hexdigest()


def contents(folder):
    """Returns the files in a folder, with a hash of each file's contents."""
    found = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        if path.is_file():
            found[str(path.relative_to(folder))] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def largest_child():
    """Returns the peak memory in bytes of the largest process that has ended so far."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024


class Run:
    """A finished run. If a signal ended the run, `code` is the signal's number with a minus sign, such as -9."""

    def __init__(self, code, out, err, seconds, hung):
        self.code, self.out, self.err, self.seconds, self.hung = code, out, err, seconds, hung

    def __str__(self):
        err = self.err if len(self.err) < 600 else self.err[:300] + " ... " + self.err[-300:]
        hung = ", was killed for it hung" if self.hung else ""
        return f"exit {self.code}{hung}, {self.seconds:.2f} s, stderr: {err.strip() or '(nothing)'}"


class Process:
    """A running process, whose working directory is `folder`."""

    def __init__(self, command, folder, environment=None, limit=None):
        self.command, self.folder = [str(word) for word in command], folder
        self.log = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        self.begin = time.monotonic()
        limited = (lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))) if limit else None
        self.process = subprocess.Popen(
            self.command, cwd=folder, stdin=subprocess.DEVNULL, stdout=self.log[0], stderr=self.log[1],
            env={**os.environ, **(environment or {})}, preexec_fn=limited)

    def running(self):
        return self.process.poll() is None

    def signal(self, number):
        if self.running():
            self.process.send_signal(number)

    def wait(self, timeout=120):
        hung = False
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            hung = True
            self.process.kill()
            self.process.wait()
        seconds, texts = time.monotonic() - self.begin, []
        for stream in self.log:
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
            stream.close()
        return Run(self.process.returncode, *texts, seconds, hung)

    def wait_until(self, happened, timeout=60):
        """Waits until happened() returns true, the process has ended, or the time is over. Returns happened()."""
        end = time.monotonic() + timeout
        while not happened():
            if not self.running() or time.monotonic() > end:
                return happened()
            time.sleep(0.001)
        return True


    def work(self, seconds):
        """Waits until the process has used this many more seconds of processor time, or has ended. Processor time does
        not depend on other load."""
        end = self.cpu_seconds() + seconds
        self.wait_until(lambda: self.cpu_seconds() >= end)

    def cpu_seconds(self):
        try:
            stat = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text()
        except (FileNotFoundError, ProcessLookupError):
            return 0
        user, system = stat[stat.rindex(")") :].split()[12:14]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


class Farm:
    """The options of the command line (the program, the folder of the scenes and others), and the failures so far."""

    def __init__(self, description, **options):
        parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawTextHelpFormatter)
        parser.add_argument("program", type=pathlib.Path)
        parser.add_argument("scenes", type=pathlib.Path)
        parser.add_argument("--only", metavar="TEXT", default="", help="run only cases whose names contain TEXT")
        parser.add_argument("--keep", action="store_true", help="keep the folders of failed cases")
        for name, (default, text) in options.items():
            if default is False:
                parser.add_argument(f"--{name}", action="store_true", help=text)
            else:
                kind = type(default) if default is not None else str
                parser.add_argument(f"--{name}", type=kind, default=default, help=text)
        self.options = parser.parse_args()
        self.program = self.options.program.resolve()
        self.scenes = self.options.scenes.resolve()
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="emberline-farm-"))
        self.failures, self.cases, self.skipped, self.begin = [], 0, [], time.monotonic()
        self.references = {}

    def is_selected(self, case):
        return self.options.only in case

    def folder(self, name):
        """Creates an empty folder. If there is one of this name, removes it first."""
        path = self.root / name.replace("/", "_").replace(" ", "_")[:120]
        if path.exists():
            shutil.rmtree(path)
        path.mkdir()
        return path

    def scene(self, name="cornell_box"):
        return self.scenes / f"{name}.glb"

    def command(self, settings, output="out.exr", scene=None):
        return [self.program, "render", scene or self.scene(), "-o", output, *settings]

    def start(self, folder, settings, output="out.exr", scene=None, environment=None, limit=None):
        return Process(self.command(settings, output, scene), folder, environment, limit)

    def run(self, folder, settings, timeout=120, **more):
        return self.start(folder, settings, **more).wait(timeout)

    def reference(self, settings, scene=None):
        """Renders without a checkpoint and without disturbance. Returns the hash of the pixels, and how many seconds
        each of two threads works on the frame, measured as processor time, which does not depend on other load. The
        results are cached."""
        key = (*map(str, settings), str(scene))
        if key not in self.references:
            folder = self.folder(f"reference {len(self.references)}")
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            run = self.run(folder, [*settings, "--quiet"], scene=scene)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            if run.code:
                raise SystemExit(f"the undisturbed run of {' '.join(key)} failed: {run}")
            spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            self.references[key] = pixels(folder / "out.exr"), spent / 2
            shutil.rmtree(folder)
        return self.references[key]

    def samples_for(self, seconds, settings):
        """Returns how many samples per pixel keep two threads busy for at least `seconds` on this machine, measured as
        processor time, which does not depend on other load."""
        key = (*map(str, settings), "samples")
        if key not in self.references:
            folder, probe = self.folder("probe"), 16
            run = self.run(folder, [*settings, "--spp", str(probe), "--report", "report.json", "--quiet"])
            if run.code:
                raise SystemExit(f"a short run of {' '.join(key[:-1])} failed: {run}")
            each = report_of(folder)["time"]["render_cpu_s"] / probe
            shutil.rmtree(folder)
            self.references[key] = max(probe, 8 * math.ceil(2 * seconds / each / 8))
        return self.references[key]

    def check(self, held, case, what, replay=""):
        """Counts a check. If the check has failed, prints the failure and how to repeat the case."""
        self.cases += 1
        if not held:
            self.failures.append(case)
            program = pathlib.Path(sys.argv[0]).name
            again = replay or f"--only '{case}'"
            print(f"FAILED {case}: {what}\n  replay: {program} {self.program} {self.scenes} {again}", flush=True)
        return held

    def check_done(self, run, folder, expected, case, allowed=(), replay=""):
        """Checks that the exit code is 0, that the picture has the right bits, and that there are no other files except
        those in `allowed`."""
        ok = self.check(run.code == EXIT_DONE, case, f"should finish: {run}", replay)
        if not ok:
            return False
        ok = self.check((folder / "out.exr").exists() and pixels(folder / "out.exr") == expected, case,
                        "the picture's bits differ", replay)
        stray = set(contents(folder)) - {"out.exr", *allowed}
        return self.check(not stray, case, f"stray files: {stray}", replay) and ok

    def check_refused(self, run, folder, before, case, codes, names=(), replay=""):
        """Checks that the exit code is one of `codes`, that there is one line on stderr, which contains all of `names`,
        and that the folder is unchanged."""
        lines = run.err.splitlines()
        ok = self.check(run.code in codes, case, f"should be refused with exit {codes}: {run}", replay)
        ok &= self.check(len(lines) == 1 and run.err.startswith("emberline: error: ") and not run.out, case,
                         f"should print one line: {run}", replay)
        for name in names:
            ok &= self.check(name in run.err, case, f"should name '{name}': {run}", replay)
        after = contents(folder)
        return ok & self.check(after == before, case, f"the folder has changed: {set(after.items()) ^ set(before.items())}",
                               replay)

    def skip(self, case, why):
        self.skipped.append(case)
        print(f"skipped {case}: {why}", flush=True)

    def done(self):
        if not (self.options.keep and self.failures):
            shutil.rmtree(self.root, ignore_errors=True)
        else:
            print(f"kept: {self.root}")
        failed = sorted(set(self.failures))
        print(f"{self.cases} checks, {len(failed)} cases failed{': ' if failed else ''}{', '.join(failed[:40])}; "
              f"{len(self.skipped)} skipped; {time.monotonic() - self.begin:.0f} s")
        sys.exit(1 if failed or not self.cases else 0)


def report_of(folder, name="report.json"):
    return json.loads((folder / name).read_text())


def earlier_samples(folder):
    return report_of(folder)["checkpoint"]["earlier_samples"]


__all__ = ["CHANNELS", "DRIVERS", "EXIT_DONE", "EXIT_INPUT", "EXIT_RENDER_FAILED", "EXIT_STOPPED", "EXIT_USAGE", "Farm",
           "Process", "SANITIZED", "contents", "earlier_samples", "largest_child", "pixels", "report_of", "signal"]
