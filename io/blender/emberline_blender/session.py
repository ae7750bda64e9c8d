"""Runs `emberline session` as a child process (renderer/session/PROTOCOL.md). Sends commands without waiting and
receives pictures."""
import collections
import json
import mmap
import queue
import subprocess
import threading

import numpy

from . import guard
from .command import EmberlineError, environment


# The pixels are linear RGBA. The first row is the bottom one, as in Blender's textures.
Picture = collections.namedtuple("Picture", "message pixels")


class Session:
    def __init__(self, program, log):
        try:
            with open(log, "wb") as out:
                pipe = subprocess.PIPE
                self._child = subprocess.Popen([program, "session"], stdin=pipe, stdout=pipe, stderr=out, env=environment())
        except OSError as error:
            raise EmberlineError(f"Emberline: {program} cannot be started: {error.strerror}") from error
        guard.watch(self._child.pid)
        self.fault = ""  # one line, set if the session has ended unexpectedly
        self.problem = ""  # why the latest change is not shown
        self._lock, self._picture, self._answers = threading.Lock(), None, []
        self._commands, self._closing = queue.SimpleQueue(), False
        for run in (self._write, self._read):
            threading.Thread(target=run, daemon=True).start()

    def send_command(self, do, **members):
        self._commands.put({"do": do, **members})

    def take_picture(self):
        """Returns the newest picture, or None if the caller has already taken it."""
        with self._lock:
            picture, self._picture = self._picture, None
        return picture

    def take_answers(self):
        with self._lock:
            answers, self._answers = self._answers, []
        return answers

    def close(self):
        self._closing = True
        self._commands.put(None)

    def _write(self):
        try:
            while (command := self._commands.get()) is not None:
                self._child.stdin.write(json.dumps(command).encode() + b"\n")
                self._child.stdin.flush()
        except (OSError, ValueError):
            return  # the reading thread notices that the session has ended
        self._child.kill()  # the session has no data that is still needed

    def _read(self):
        memory, segment = None, None
        try:
            for line in self._child.stdout:
                message = json.loads(line)
                event = message.get("event")
                if event == "picture":
                    if message["segment"] != segment:
                        with open(message["memory"], "rb") as file:
                            memory = mmap.mmap(file.fileno(), message["bytes"], access=mmap.ACCESS_READ)
                        segment = message["segment"]
                    picture = Picture(message, _pixels(memory, message))
                    with self._lock:
                        self._picture = picture
                    self.send_command("next", after=message["number"])
                elif event == "problem":
                    self.problem = message.get("text", "")
                elif event == "error":
                    self.fault = message.get("text", "")
                elif "ok" in message:
                    with self._lock:
                        self._answers.append(message)
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            self.fault = self.fault or f"the session sent an invalid message: {error}"
            self._child.kill()
        code = self._child.wait()
        guard.forget(self._child.pid)
        if not self._closing:
            self.fault = self.fault or (f"the session crashed (signal {-code})" if code < 0 else f"the session ended with exit code {code}")


def _pixels(memory, picture):
    width, height = picture["width"], picture["height"]
    rows = numpy.frombuffer(memory, numpy.uint8, picture["stride"] * height, picture["offset"]).reshape(height, -1)
    return numpy.ascontiguousarray(rows[::-1, : 16 * width]).view("<f4")
