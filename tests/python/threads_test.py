"""Tests callbacks, Ctrl-C and other threads while a frame renders."""
import os
import signal
import tempfile
import threading
import time
import unittest

import numpy as np

import emberline
from support import BOX, SMALL, Test, python

LONG = {"spp": 1 << 24}


class Mine(Exception):
    pass


class Callbacks(Test):
    def test_progress(self):
        for driver, pictures in (("bucket", False), ("bisection", True), ("adaptive", True)):
            with self.subTest(driver):
                seen = []
                caller = threading.current_thread()

                def progress(now):
                    self.assertIs(threading.current_thread(), caller)
                    seen.append(now)

                picture = emberline.render(self.box, driver=driver, spp=64, bucket_size=8, progress=progress)
                self.assertGreater(len(seen), 2)
                samples = [now.samples for now in seen]
                self.assertEqual(samples, sorted(samples))
                self.assertEqual(samples[-1], picture.samples)
                for now in seen:  # each object must still have its data
                    self.assertEqual(now.rgba is not None, pictures)
                if pictures:
                    self.assertEqual(seen[0].rgba.shape, (16, 24, 4))
                    np.testing.assert_allclose(seen[-1].rgba[..., :3], picture["RGB"], atol=1e-6)
                    self.assertGreater(np.abs(seen[0].rgba - seen[-1].rgba).max(), 0.01)

    def test_an_exception_comes_out_as_itself(self):
        for driver in ("bucket", "bisection", "adaptive"):
            with self.subTest(driver):
                error = Mine("1")
                calls = []

                def progress(now):
                    calls.append(now)
                    raise error

                start = time.process_time()
                with self.assertRaises(Mine) as caught:
                    emberline.render(self.box, driver=driver, spp=1 << 16, bucket_size=4, progress=progress)
                self.assertIs(caught.exception, error)
                self.assertEqual(len(calls), 1)
                self.assertLess(time.process_time() - start, 30)
        emberline.render(self.box)

    def test_false_ends_it(self):
        picture = emberline.render(self.box, driver="bisection", **LONG, progress=lambda now: now.samples < 5000)
        self.assertFalse(picture.complete)
        self.assertGreaterEqual(picture.samples, 5000)
        self.assertTrue(emberline.render(self.box, driver="bisection", progress=lambda now: 0).complete)
        picture = emberline.render(self.box, driver="bisection", **LONG, progress=lambda now: np.bool_(now.samples < 5000))
        self.assertFalse(picture.complete)

    def test_a_scene_is_not_edited_while_it_renders(self):
        scene = emberline.Scene(BOX, **SMALL)
        with self.assert_error(emberline.UsageError, "cannot be edited while it is rendered"):
            emberline.render(scene, driver="bisection", progress=lambda now: scene.edit({}))
        scene.edit({})
        inner = []
        picture = emberline.render(
            scene, bucket_size=8, progress=lambda now: inner.append(emberline.render(scene)["RGB"])
        )
        for rgb in inner:
            np.testing.assert_array_equal(rgb, picture["RGB"])

    def test_other_threads_run_meanwhile(self):
        alone = emberline.render(self.box, spp=64)["RGB"]
        ticks, done = [0], threading.Event()

        def count():
            while not done.wait(0.001):
                ticks[0] += 1

        counter = threading.Thread(target=count)
        counter.start()
        pictures = [None] * 4

        def work(i):
            pictures[i] = emberline.render(self.box, spp=64, threads=1 + i % 2)["RGB"]

        workers = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        done.set()
        counter.join()
        self.assertGreater(ticks[0], 0)
        # This render ends only because another thread sends a signal.
        ended = threading.Event()

        def end():
            for _ in range(50):
                ended.wait(0.001)
            os.kill(os.getpid(), signal.SIGINT)

        killer = threading.Thread(target=end)
        killer.start()
        with self.assertRaises(KeyboardInterrupt):
            emberline.render(self.box, spp=1 << 24)
        killer.join()
        for picture in pictures:
            np.testing.assert_array_equal(picture, alone)


# This script renders until Ctrl-C. Then it prints how soon the render returned, and how many threads are left. It waits
# because a joined thread is still listed for a moment.
INTERRUPTED = """
import os, sys, time, signal, threading
import emberline
scene_file = sys.argv[1]
for case in sys.argv[2:]:
    driver, threads, watched = case.split(",")
    threads = int(threads)
    scene = emberline.Scene(scene_file, size=(320, 240), threads=threads)
    sent = []
    begun = time.process_time()
    def press():
        while time.process_time() < begun + 0.15:
            time.sleep(0.002)
        sent.append(time.process_time())
        os.kill(os.getpid(), signal.SIGINT)
    key = threading.Thread(target=press)
    key.start()
    progress = (lambda now: None) if watched == "yes" else None
    try:
        emberline.render(scene, driver=driver, spp=1 << 24, threads=threads, progress=progress)
    except KeyboardInterrupt:
        took = time.process_time() - sent[0]
        key.join()
        tasks = lambda: len(os.listdir("/proc/self/task"))
        patience = time.monotonic() + 60
        while tasks() > 1 and threads == 1 and time.monotonic() < patience:
            time.sleep(0.01)
        print(took, tasks())
        emberline.render(scene, spp=1)
"""


class Interrupts(Test):
    def test_ctrl_c(self):
        # The cases with one thread come first. After the other cases, TBB keeps its threads for the next render.
        cases = ["bucket,1,no", "bisection,1,no", "adaptive,1,yes", "bucket,0,no", "bucket,0,yes", "bisection,0,yes",
                 "adaptive,0,no"]
        with tempfile.TemporaryDirectory() as folder:
            process = python(INTERRUPTED, BOX, *cases, cwd=folder)
            out, err = process.communicate(timeout=200)
            self.assertEqual((process.returncode, err, os.listdir(folder)), (0, "", []))
        for case, line in zip(cases, out.splitlines(), strict=True):
            with self.subTest(case):
                took, left = line.split()
                print(f"Ctrl-C, {case}: {1000 * float(took):.0f} ms of processor time")
                self.assertLess(float(took), 0.2 * os.cpu_count())
                if ",1," in case:
                    self.assertEqual(int(left), 1)

    def test_a_merge(self):
        """Checks that a merge ends early if a signal handler raises an exception while parts are read and added."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        parts = [os.path.join(folder.name, str(i)) for i in (1, 2)]
        large = emberline.Scene(BOX, size=(1024, 1024), spp=1, integrator="albedo", bucket_size=8)
        for i, part in enumerate(parts):
            emberline.render(large, part=f"{i + 1}/2", checkpoint=part)
        start = time.process_time()
        emberline.merge(parts)
        whole = time.process_time() - start

        def handler(*_):
            raise Mine("handler")

        before = signal.signal(signal.SIGPROF, handler)
        self.addCleanup(signal.signal, signal.SIGPROF, before)
        signal.setitimer(signal.ITIMER_PROF, whole / 8)
        start = time.process_time()
        with self.assertRaises(Mine):
            emberline.merge(parts)
        self.assertLess(time.process_time() - start, whole)

    def test_a_handler_of_ones_own(self):
        def handler(*_):
            raise Mine("handler")

        before = signal.signal(signal.SIGALRM, handler)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.05)
            with self.assertRaisesRegex(Mine, "handler"):
                emberline.render(self.box, **LONG)
        finally:
            signal.signal(signal.SIGALRM, before)

    def test_the_interpreter_ends_amid_a_render(self):
        code = """
import sys, threading, time
import emberline
scene = emberline.Scene(sys.argv[1], size=(64, 48))
begun = threading.Event()
def work():
    emberline.render(scene, driver="bisection", spp=1 << 24, progress=lambda now: begun.set())
threading.excepthook = lambda args: None
threading.Thread(target=work, daemon=True).start()
begun.wait()
time.sleep(0.02)
"""
        process = python(code, BOX)
        out, err = process.communicate(timeout=100)
        self.assertEqual((process.returncode, out, err), (0, "", ""))

    def test_a_forked_process_says_so(self):
        code = """
import os, sys
import emberline
scene = emberline.Scene(sys.argv[1], size=(8, 8), spp=1)
child = os.fork()
if child == 0:
    try:
        emberline.render(scene)
    except emberline.RenderError as error:
        os._exit(0 if "spawn" in str(error) else 1)
    os._exit(2)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
        process = python(code, BOX)
        _, err = process.communicate(timeout=100)
        self.assertEqual((process.returncode, err), (0, ""))

    def test_a_process_forked_amid_a_render_ends(self):
        # The script forks this many times, each time at another moment of a render.
        forks = 10 if os.environ.get("EMBERLINE_LONG_TESTS", "0") not in ("", "0") else 3
        code = """
import gc, os, sys, threading, time
import emberline
file, forks = sys.argv[1], int(sys.argv[2])
parent = os.getpid()
def child():
    if what == "exit":
        sys.exit(7)
    if what == "forget":
        globals().pop("scene")
        gc.collect()
        sys.exit(7)
    try:
        emberline.read(file) if what == "read" else scene.edit({}) if what == "edit" else emberline.render(scene)
    except emberline.Error:
        sys.exit(7)
def wait(pid):
    patience = time.monotonic() + 60
    while time.monotonic() < patience:
        found, status = os.waitpid(pid, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
    os.kill(pid, 9)
    return "it hangs"
def progress(now):
    begun.set()
    if what == "callback" and len(forked) < forks:
        pid = os.fork()
        if pid == 0:
            return sys.exit(7) if len(forked) % 2 else None
        forked.append(wait(pid))
    return not ended.is_set()
def work():
    try:
        emberline.render(scene, driver="bisection", spp=1 << 24, progress=progress)
    except (emberline.RenderError, SystemExit):
        os._exit(7 if os.getpid() != parent else 1)
for what in ("exit", "forget", "read", "edit", "render", "callback"):
    scene = emberline.Scene(file, size=(64, 48))
    begun, ended, forked = threading.Event(), threading.Event(), []
    thread = threading.Thread(target=work)
    thread.start()
    begun.wait()
    while what != "callback" and len(forked) < forks:
        pid = os.fork()
        if pid == 0:
            child()
            os._exit(1)
        forked.append(wait(pid))
    while len(forked) < forks:
        time.sleep(0.01)
    ended.set()
    thread.join()
    print(what, *forked, flush=True)
"""
        process = python(code, BOX, forks)
        out, err = process.communicate(timeout=290)
        self.assertEqual((process.returncode, err), (0, ""))
        self.assertEqual(dict(line.split(" ", 1) for line in out.splitlines()),
                         dict.fromkeys(("exit", "forget", "read", "edit", "render", "callback"), " ".join(forks * "7")))


if __name__ == "__main__":
    unittest.main()
