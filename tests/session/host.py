"""Runs `emberline session` as a host, for its tests, and renders reference pictures with `emberline render`."""
import contextlib
import json
import mmap
import os
import struct
import subprocess
import sys
import threading
import time

PROGRAM, SCENES, EXAMPLE = sys.argv[1:4]
SCENE = os.path.join(SCENES, "cornell_box.glb")
TIMEOUT_S = 240  # is also enough for a sanitized program


def wait_until(true, seconds=30):
    end = time.monotonic() + seconds
    while not true() and time.monotonic() < end:
        time.sleep(0.02)
    return true()


def shared_memory():
    """Returns shared memory segments that could be ours. Other programs may create and remove segments meanwhile."""
    return sorted(name for name in os.listdir("/dev/shm") if "emberline" in name.lower())


class Host:
    """A host that reads and acknowledges pictures, unless a test does something else."""

    def __init__(self, *options):
        self.process = subprocess.Popen([PROGRAM, "session", "--threads", "2", *options], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.watchdog = threading.Timer(TIMEOUT_S, self.process.kill)
        self.watchdog.start()
        self.commands, self.segment, self.memory, self.events = 0, 0, None, []
        self.hello = json.loads(self.process.stdout.readline())

    def close(self):
        self.process.kill()
        self.process.wait()
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            with contextlib.suppress(BrokenPipeError):
                stream.close()
        self.watchdog.cancel()

    def send(self, data):
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write(data)
            self.process.stdin.flush()

    def send_command(self, do, **members):
        self.send(json.dumps({"do": do, **members}).encode() + b"\n")

    def read(self):
        line = self.process.stdout.readline()
        if not line:
            return None
        message = json.loads(line)
        self.events.append(message)
        return message

    def receive(self, accept):
        while (message := self.read()) is not None:
            if message.get("event") == "picture":
                self.send_command("next", after=message["number"])
            if accept(message):
                return message
        raise AssertionError("the session has ended: " + self.process.stderr.read().decode())

    def request(self, do, **members):
        self.commands += 1
        self.send_command(do, id=self.commands, **members)
        return self.receive(lambda m: m.get("id") == self.commands)

    def map(self, picture):
        if picture["segment"] != self.segment:
            with open(picture["memory"], "rb") as file:
                self.memory = mmap.mmap(file.fileno(), picture["bytes"], access=mmap.ACCESS_READ)
            self.segment = picture["segment"]
        begin = picture["offset"]
        return self.memory[begin:begin + picture["stride"] * picture["height"]]

    def picture(self, good):
        found = self.receive(lambda m: m.get("event") == "picture" and good(m))
        return found, self.map(found)

    def finished(self, edit=0):
        return self.picture(lambda p: p["finished"] and p["edit"] >= edit)

    def end(self, data=None):
        """Sends `data` and closes standard input. Returns the exit code, all events, and the lines of stderr."""
        if data is not None:
            self.send(data)
        out, err = self.process.communicate()
        self.watchdog.cancel()
        return self.process.returncode, [json.loads(line) for line in out.splitlines()], err.decode().splitlines()


def rgba_of(exr):
    """Returns R, G, B and A of an uncompressed EXR with scan lines and float channels, in rows from the top."""
    with open(exr, "rb") as file:
        data = file.read()
    at, header = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)[0:3]
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<i", data, at)
        header[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    assert header[b"compression"] == b"\0", "the test reads uncompressed files"
    x0, y0, x1, y1 = struct.unpack("<4i", header[b"dataWindow"])
    names, channels = [], header[b"channels"]
    while channels[0]:
        name, channels = channels.split(b"\0", 1)
        names.append(name.decode())
        channels = channels[16:]
    width, height = x1 - x0 + 1, y1 - y0 + 1
    side_x, side_y = struct.unpack_from("<2I", header[b"tiles"]) if b"tiles" in header else (width, 1)
    count = -(-width // side_x) * -(-height // side_y)
    pixels = bytearray(16 * width * height)
    for offset in struct.unpack_from(f"<{count}Q", data, at + 1):
        if b"tiles" in header:
            left, top = (a * b for a, b in zip(struct.unpack_from("<2i", data, offset), (side_x, side_y)))
            offset += 20
        else:
            left, top = 0, struct.unpack_from("<i", data, offset)[0] - y0
            offset += 8
        columns = min(side_x, width - left)
        for y in range(top, min(top + side_y, height)):
            for name in names:
                if name in "RGBA":
                    for x in range(columns):
                        to = 16 * (y * width + left + x) + 4 * "RGBA".index(name)
                        pixels[to:to + 4] = data[offset + 4 * x:offset + 4 * x + 4]
                offset += 4 * columns
    return bytes(pixels)


def rendered(folder, *options):
    out = os.path.join(folder, "frame.exr")
    subprocess.run([PROGRAM, "render", SCENE, "-o", out, "--exr-compression", "none", "--threads", "2", "-q", *options],
                   check=True)
    return rgba_of(out)
