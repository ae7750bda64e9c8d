"""Removes child processes and temporary files when Blender ends, even if Blender is killed.

A small helper process waits on a pipe from Blender. When the pipe closes, the helper kills the remaining children and
removes the folder with all our files. The helper runs this file, which must not import Blender modules.
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

_lock = threading.Lock()
_helper = None  # the helper process
_folder = None


def folder():
    """Returns a new private folder, which is removed no later than when Blender ends."""
    global _helper, _folder
    with _lock:
        if not _folder or not os.path.isdir(_folder):
            stop()
            _folder = tempfile.mkdtemp(prefix="emberline-blender-")
            arguments = [sys.executable, "-I", "-S", os.path.abspath(__file__), _folder]
            try:
                # The helper runs in a new session, so that Ctrl-C in Blender's terminal does not reach it.
                _helper = subprocess.Popen(
                    arguments,
                    bufsize=0,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    start_new_session=True,
                )
            except OSError:
                _helper = None  # without the helper, files stay behind if Blender is killed
        return tempfile.mkdtemp(dir=_folder)


def last_frame():
    """Returns the path of the last finished frame's EXR, from which heatmaps are made."""
    return os.path.join(_folder or tempfile.gettempdir(), "emberline-last-frame.exr")


def _notify_helper(sign, child):
    with _lock:
        try:
            if _helper:
                _helper.stdin.write(b"%c%d\n" % (sign, child))
        except (OSError, ValueError):
            pass  # the helper has ended


def watch(child):
    _notify_helper(b"+", child)


def forget(child):
    _notify_helper(b"-", child)


def stop():
    """Cleans up now, as the helper would when Blender ends."""
    global _helper, _folder
    if _helper:
        ended, _helper = _helper, None
        ended.stdin.close()
        ended.wait()
    if _folder:
        shutil.rmtree(_folder, ignore_errors=True)
    _helper = _folder = None


def _run_helper(path):
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
    _run_helper(sys.argv[1])
