"""What must not outlive Blender: our child processes and our temporary files, even when Blender is killed.

A small process of its own waits at a pipe from Blender. When that ends, it kills the children that still run and removes the
folder in which all our files lie. This file is also its program: it imports nothing of Blender.
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

_lock = threading.Lock()
_guard = None  # the process
_folder = None


def folder():
    """A new private folder, which goes with Blender at the latest."""
    global _guard, _folder
    with _lock:
        if not _folder or not os.path.isdir(_folder):
            stop()
            _folder = tempfile.mkdtemp(prefix="emberline-blender-")
            arguments = [sys.executable, "-I", "-S", os.path.abspath(__file__), _folder]
            try:
                # A session of its own: Ctrl-C in Blender's terminal is not meant for it.
                _guard = subprocess.Popen(
                    arguments,
                    bufsize=0,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,
                )
            except OSError:
                _guard = None  # then only a killed Blender leaves something
        return tempfile.mkdtemp(dir=_folder)


def last_frame():
    """The EXR of the last finished frame, for heatmaps."""
    return os.path.join(_folder or tempfile.gettempdir(), "emberline-last-frame.exr")


def _tell(sign, child):
    with _lock:
        try:
            if _guard:
                _guard.stdin.write(b"%c%d\n" % (sign, child))
        except (OSError, ValueError):
            pass  # it has ended


def watch(child):
    _tell(b"+", child)


def forget(child):
    _tell(b"-", child)


def stop():
    """Ends what is left, as the end of Blender does."""
    global _guard, _folder
    if _guard:
        ended, _guard = _guard, None
        ended.stdin.close()
        ended.wait()
    if _folder:
        shutil.rmtree(_folder, ignore_errors=True)
    _guard = _folder = None


def _stand_guard(path):
    children = set()
    for line in sys.stdin.buffer:
        (children.add if line[:1] == b"+" else children.discard)(int(line[1:]))
    for child in children:
        try:
            os.kill(child, getattr(signal, "SIGKILL", signal.SIGTERM))
        except OSError:
            pass
    shutil.rmtree(path, ignore_errors=True)


if __name__ == "__main__":
    _stand_guard(sys.argv[1])
