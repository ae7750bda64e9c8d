"""Finds the command `emberline`, and runs and monitors a render as a child process."""
import json
import os
import shutil
import socket
import struct
import subprocess
import threading

import numpy

from . import guard


class EmberlineError(Exception):
    """Raised if nothing can be rendered. The message is one line for the user."""


def find(preferred=""):
    """Finds the command: from the preferences, on PATH, or beside the add-on."""
    name = "emberline.exe" if os.name == "nt" else "emberline"
    if preferred:
        found = shutil.which(preferred)
        if not found:
            raise EmberlineError(f"Emberline: {preferred} is not an executable program; change the path in Preferences > Add-ons > Emberline")
        return found
    here = os.path.dirname(os.path.abspath(__file__))
    for folder in (None, here, os.path.join(here, "bin"), os.path.dirname(here)):
        found = shutil.which(name) if folder is None else shutil.which(os.path.join(folder, name))
        if found:
            return found
    raise EmberlineError("Emberline: the program was not found on PATH or next to the add-on; set its path in Preferences > Add-ons > Emberline")


def environment():
    """Returns the environment for child processes, without OCIO. Blender 5 sets that variable to its own configuration,
    but we need linear images."""
    return {name: value for name, value in os.environ.items() if name != "OCIO"}


class Viewer:
    """Receives the unfinished picture (RGBA, rows from the top), which the command sends because of `--display tev://`.

    The protocol is that of the image viewer tev (io/viewer/tev_protocol.h). Only our own child process knows the port.
    """

    _CREATE, _UPDATE = 4, 6

    def __init__(self, width, height):
        self.picture = numpy.zeros((height, width, 4), numpy.float32)
        self._changed = False
        self._lock = threading.Lock()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = "tev://127.0.0.1:%d" % self._listener.getsockname()[1]
        self._connection = None
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        try:
            self._connection, _ = self._listener.accept()
            with self._connection, self._connection.makefile("rb") as stream:
                while True:
                    size = stream.read(4)
                    if len(size) < 4:
                        return
                    (length,) = struct.unpack("<I", size)
                    if not 5 <= length <= 1 << 26:
                        return
                    packet = stream.read(length - 4)
                    if len(packet) < length - 4:
                        return
                    if packet[0] == self._UPDATE:
                        self._update(packet)
        except (OSError, ValueError, struct.error):
            pass  # the final image is read from the file in any case

    def _update(self, packet):
        at = packet.index(b"\0", 2) + 1  # after the name
        (channels,) = struct.unpack_from("<i", packet, at)
        at += 4
        for _ in range(channels):
            at = packet.index(b"\0", at) + 1
        x, y, w, h = struct.unpack_from("<4i", packet, at)
        at += 16 + 16 * channels  # skips offsets and strides: our pixels are interleaved
        pixels = numpy.frombuffer(packet, "<f4", channels * w * h, at).reshape(h, w, channels)
        with self._lock:
            self.picture[y : y + h, x : x + w, :channels] = pixels
            self._changed = True

    def take(self):
        """Returns a copy of the picture, or None if it has not changed since the last call."""
        with self._lock:
            if not self._changed:
                return None
            self._changed = False
            return self.picture.copy()

    def close(self):
        for end in (self._listener, self._connection):
            try:
                if end:
                    end.close()
            except OSError:
                pass


class Process:
    """A running command. Its log goes to a file in `folder`."""

    def __init__(self, arguments, folder):
        self._log = os.path.join(folder, "log.txt")
        self._progress = os.path.join(folder, "progress.json")
        try:
            with open(self._log, "wb") as log:
                self._child = subprocess.Popen(
                    arguments + ["--progress-file", self._progress],
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    cwd=folder,
                    env=environment(),
                )
        except OSError as error:
            raise EmberlineError(f"Emberline: {arguments[0]} cannot be started: {error.strerror}") from error
        guard.watch(self._child.pid)

    def wait(self, seconds):
        """Returns the exit code, or None if the process is still running."""
        try:
            code = self._child.wait(seconds)
        except subprocess.TimeoutExpired:
            return None
        guard.forget(self._child.pid)
        return code

    def progress(self):
        """Returns the contents of --progress-file: done (0 to 1), samples, left_s; {} if there is none yet."""
        try:
            with open(self._progress, encoding="utf-8") as file:
                return json.load(file)
        except (OSError, ValueError):
            return {}

    def kill(self):
        self._child.kill()
        self._child.wait()
        guard.forget(self._child.pid)

    def fault(self, code):
        """Returns one line that describes the error."""
        with open(self._log, encoding="utf-8", errors="replace") as file:
            lines = [line.strip() for line in file if line.strip()]
        message = next((line for line in reversed(lines) if "error" in line.lower()), lines[-1] if lines else "")
        if code < 0:
            return f"Emberline crashed (signal {-code})" + (f": {message}" if message else "")
        return f"Emberline failed (exit code {code})" + (f": {message}" if message else "")
