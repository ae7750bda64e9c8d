"""Runs the window on a virtual screen, and sends it real key and mouse events through XTest."""
import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import zlib

# The timeout can be raised, because sanitized builds and busy machines are slow.
TIMEOUT_S = float(os.environ.get("EMBERLINE_VIEW_PATIENCE", "60"))


def missing_programs():
    return [name for name in ("Xvfb", "xdotool") if shutil.which(name) is None]


# These are the key codes of the function keys. If xdotool got a function key's name, it would also press alt if the
# keyboard map has five levels for that key.
FUNCTION_KEYS = {f"F{i + 1}": code for i, code in enumerate([*range(67, 77), 95, 96])}


class Display:
    """A separate X server with software OpenGL."""

    def __init__(self, width=1280, height=800):
        read, write = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp"],
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        if not number:
            raise RuntimeError("Xvfb did not start")
        self.environment = dict(os.environ, DISPLAY=":" + number, LIBGL_ALWAYS_SOFTWARE="1")
        self.environment.pop("WAYLAND_DISPLAY", None)

    def xdotool(self, *words):
        result = subprocess.run(["xdotool", *map(str, words)], env=self.environment, text=True,
                                capture_output=True, timeout=TIMEOUT_S)
        return result.stdout.strip()

    def close(self):
        self.process.terminate()
        self.process.wait()


class Window:
    """A running `emberline view`. Its journal tells what it does."""

    def __init__(self, display, binary, *words, size=(1000, 640), environment=None):
        self.display = display
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="emberline-view-"))
        self.journal = self.folder / "journal.jsonl"
        self.events = []
        self.read_to = 0
        options = dict(display.environment, XDG_CONFIG_HOME=str(self.folder / "config"))
        options.update(environment or {})
        self.log = open(self.folder / "log.txt", "w+")
        self.process = subprocess.Popen(
            [binary, "view", *map(str, words), "--window", f"{size[0]}x{size[1]}", "--journal",
             str(self.journal)],
            env=options, cwd=self.folder, stdout=self.log, stderr=self.log)

    # ---- observation

    def update(self):
        if not self.journal.exists():
            return
        with open(self.journal, "rb") as file:
            file.seek(self.read_to)
            text = file.read()
        whole = text.rfind(b"\n") + 1
        self.read_to += whole
        self.events += [json.loads(line) for line in text[:whole].splitlines()]

    def last(self, name):
        self.update()
        return next((e for e in reversed(self.events) if e["event"] == name), None)

    def wait_for(self, name, accept=lambda event: True, since=0, seconds=TIMEOUT_S):
        """Waits for an event with this name that `accept` accepts, and returns the first one. Skips the first `since`
        events."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.update()
            for event in self.events[since:]:
                if event["event"] == name and accept(event):
                    return event
            if self.process.poll() is not None:
                raise AssertionError(f"it ended with {self.process.returncode} before '{name}' came: {self.log_text()}")
            time.sleep(0.02)
        raise AssertionError(f"no '{name}' after {seconds} s; the last events: {self.events[-5:]}; {self.log_text()}")

    def wait_until_finished(self, since=0):
        return self.wait_for("picture", lambda e: e["finished"], since)

    def mark(self):
        self.update()
        return len(self.events)

    def log_text(self):
        self.log.flush()
        self.log.seek(0)
        return self.log.read()

    # ---- input

    def focus(self):
        window = self.display.xdotool("search", "--sync", "--onlyvisible", "--class", "emberline").split()[-1]
        self.display.xdotool("windowfocus", "--sync", window)
        return window

    def key(self, *keys):
        self.display.xdotool("key", *(FUNCTION_KEYS.get(key, key) for key in keys))

    def type(self, text):
        self.display.xdotool("type", "--delay", "5", text)

    def screen_of(self, x, y):
        """Returns the screen coordinates of the centre of a pixel of the picture."""
        picture = self.last("placed")
        zoom = picture["zoom"]
        return (round(picture["at"][0] + (x + 0.5) * zoom), round(picture["at"][1] + (y + 0.5) * zoom))

    def move_to_pixel(self, x, y):
        self.display.xdotool("mousemove", *self.screen_of(x, y))

    def drag(self, way, button=1, key=None, steps=10, start=None):
        x, y = start or self.screen_of(*[side // 2 for side in self.last("picture")["size"]])
        words = ["mousemove", x, y]
        if key:
            words += ["keydown", key]
        words += ["mousedown", button]
        for i in range(1, steps + 1):
            words += ["mousemove", x + way[0] * i // steps, y + way[1] * i // steps]
        words += ["mouseup", button]
        if key:
            words += ["keyup", key]
        self.display.xdotool(*words)

    def screenshot(self):
        """Returns the window's contents as (width, height, rows of RGB). The window saves them when F12 is pressed."""
        since = self.mark()
        self.key("F12")
        text = self.wait_for("message", lambda e: "Screenshot saved" in e["text"], since)["text"]
        return read_png(self.folder / text.split(": ", 1)[1])

    # ---- exit

    def end(self, send=None, seconds=TIMEOUT_S):
        """Ends the window with ctrl+Q or with a signal. Returns its exit code."""
        if self.process.poll() is None:
            if send is None:
                self.key("ctrl+q")
            else:
                self.process.send_signal(send)
        return self.process.wait(seconds)

    def close(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
            self.process.wait()
        self.log.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def read_png(path):
    """Reads an 8-bit RGB or RGBA PNG. Returns (width, height, rows), where rows are bytes of RGB."""
    data = pathlib.Path(path).read_bytes()
    at, packed, header = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    width, height, depth, colour = header[:4]
    assert depth == 8 and colour in (2, 6), header
    n = 3 if colour == 2 else 4
    raw, rows, before = zlib.decompress(packed), [], bytes(width * n)
    for y in range(height):
        start = y * (width * n + 1)
        row = bytearray(raw[start + 1:start + 1 + width * n])
        unfilter(raw[start], row, before, n)
        before = bytes(row)
        rows.append(before if n == 3 else bytes(b for i, b in enumerate(before) if i % 4 != 3))
    return width, height, rows


def unfilter(kind, row, before, n):
    """Reverses a row filter (PNG specification, section 9.2)."""
    for i in range(len(row) if kind else 0):  # kind 0 is no filter
        left = row[i - n] if i >= n else 0
        up, corner = before[i], before[i - n] if i >= n else 0
        if kind == 1:
            row[i] = (row[i] + left) & 255
        elif kind == 2:
            row[i] = (row[i] + up) & 255
        elif kind == 3:
            row[i] = (row[i] + (left + up) // 2) & 255
        elif kind == 4:
            p = left + up - corner
            nearest = min((abs(p - left), 0, left), (abs(p - up), 1, up), (abs(p - corner), 2, corner))
            row[i] = (row[i] + nearest[2]) & 255
