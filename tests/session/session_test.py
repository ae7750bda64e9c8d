"""Tests `emberline session` as a host uses it: a real process, its lines and its shared memory, also with hosts that
misbehave.

    session_test.py PROGRAM SCENES EXAMPLE [TEST...]
"""
import contextlib
import fcntl
import json
import math
import mmap
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from host import EXAMPLE, TIMEOUT_S, PROGRAM, SCENE, SCENES, Host, rendered, shared_memory, wait_until


class SessionTest(unittest.TestCase):
    def setUp(self):
        self.shm = shared_memory()
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def tearDown(self):
        self.assertEqual(shared_memory(), self.shm)

    def host(self, *options):
        host = Host(*options)
        self.addCleanup(host.close)
        return host

    def opened(self, *options, **members):
        host = self.host("--size", "64x48", "--driver", "bisection", "--spp", "4", *options)
        answer = host.request("open", scene=SCENE, **members)
        self.assertTrue(answer["ok"], answer)
        return host, answer


class Pictures(SessionTest):
    COMMON = ("--size", "64x48", "--driver", "bisection", "--spp", "4")

    def test_hello(self):
        hello = self.host().hello
        self.assertEqual((hello["event"], hello["protocol"]), ("hello", 1))
        self.assertIn(hello["emberline"], subprocess.check_output([PROGRAM, "--version"]).decode())
        self.assertTrue(hello["isa"] and hello["pid"])

    def test_bits_of_render(self):
        host, answer = self.opened()
        picture, pixels = host.finished()
        self.assertEqual((picture["width"], picture["height"], picture["format"]), (64, 48, "linear"))
        self.assertTrue(picture["complete"] and picture["edit"] >= answer["edit"])
        self.assertEqual(pixels, rendered(self.folder.name, *self.COMMON))

    def test_bits_after_camera_and_edits(self):
        camera = {"look_from": [1.5, 1.2, 4], "look_at": [0, 1, 0], "fov_y": 45}
        material = {"index": 0, "base_color": [0.9, 0.2, 0.1], "roughness": 0.4}
        host, answer = self.opened()
        host.request("camera", camera=camera)
        edit = host.request("edits", edits={"materials": [{"index": 0, "base_color": [0, 0, 1]}]})["edit"]
        edit = host.request("edits", edits={"materials": [material]})["edit"]  # replaces the edit before it
        pixels = host.finished(edit)[1]
        look = os.path.join(self.folder.name, "look.json")
        with open(look, "w") as file:
            json.dump({"emberline_edits": 1, "camera": camera, "materials": [material]}, file)
        self.assertEqual(pixels, rendered(self.folder.name, *self.COMMON, "--edits", look))
        # If the session saves these edits, they give the same picture.
        self.assertTrue(host.request("save", file=look)["ok"])
        self.assertEqual(pixels, rendered(self.folder.name, *self.COMMON, "--edits", look))
        # The camera and the materials can be reset separately.
        host.request("camera", camera=None)
        edit = host.request("edits", edits={"materials": None})["edit"]
        self.assertEqual(host.finished(edit)[1], rendered(self.folder.name, *self.COMMON))

    def test_matrix(self):
        host, _ = self.opened()
        view = {"look_from": [0, 1, 5], "look_at": [0, 1, 4], "fov_y": 40}
        seen = host.finished(host.request("camera", camera=view)["edit"])[1]
        host.finished(host.request("camera", camera={**view, "look_from": [1, 1, 5]})["edit"])
        matrix = [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 1, 5, 1]
        again = host.finished(host.request("camera", camera={"matrix": matrix, "fov_y": 40})["edit"])[1]
        self.assertEqual(seen, again)
        mirrored = host.finished(host.request("camera", camera={"matrix": [-2] + matrix[1:], "fov_y": 40})["edit"])[1]
        row = 64 * 16
        self.assertNotEqual(seen, mirrored)
        # Up to its noise, the picture must show the mirrored scene.
        def mean(pixels, x0, x1):
            values = [struct.unpack_from("<f", pixels, y * row + 16 * x)[0] for y in range(48) for x in range(x0, x1)]
            return sum(values) / len(values)
        self.assertAlmostEqual(mean(seen, 0, 32), mean(mirrored, 32, 64), delta=0.1 * mean(seen, 0, 32))

    def test_crop(self):
        host, _ = self.opened()
        edit = host.request("settings", settings={"crop": "10,5,40,33"})["edit"]
        picture, pixels = host.finished(edit)
        self.assertEqual([picture[k] for k in ("x", "y", "width", "height")], [10, 5, 30, 28])
        self.assertEqual(pixels, rendered(self.folder.name, *self.COMMON, "--crop", "10,5,40,33"))
        saved = os.path.join(self.folder.name, "crop.png")
        self.assertTrue(host.request("save", file=saved)["ok"])
        edit = host.request("settings", settings={"crop": None})["edit"]
        self.assertEqual(host.finished(edit)[1], rendered(self.folder.name, *self.COMMON))
        refused = host.request("settings", settings={"crop": "10,5,400,33"})
        problem = host.receive(lambda m: m.get("event") == "problem" and m["text"])["text"]
        self.assertTrue(refused["ok"] and "--crop" in problem, problem)

    def test_crop_by_all_drivers(self):
        host, _ = self.opened()
        for session, render in (("bucket", "bucket"), ("adaptive", "adaptive"), ("live", "adaptive")):
            for crop in (None, "20,7,61,40"):
                edit = host.request("settings", settings={"driver": session, "spp": 8, "crop": crop})["edit"]
                options = ("--crop", crop) if crop else ()
                self.assertEqual(host.finished(edit)[1], rendered(self.folder.name, "--size", "64x48", "--driver", render,
                                                                  "--spp", "8", *options), (session, crop))

    def test_saved_crop(self):
        host, _ = self.opened()
        host.finished(host.request("settings", settings={"crop": "10,5,40,33"})["edit"])
        ours, theirs = (os.path.join(self.folder.name, name) for name in ("ours.exr", "theirs.exr"))
        self.assertTrue(host.request("save", file=ours)["ok"])
        subprocess.run([PROGRAM, "render", SCENE, "-o", theirs, "-q", *self.COMMON, "--crop", "10,5,40,33"], check=True)
        compared = subprocess.check_output([PROGRAM, "compare", ours, theirs, "--json"])
        self.assertEqual(json.loads(compared)["mse"], 0)

    def test_dialogue_of_the_protocol(self):
        host = self.host()
        with open(os.path.join(os.path.dirname(EXAMPLE), "PROTOCOL.md"), encoding="utf-8") as file:
            lines = [line.strip() for line in file if line.startswith("    ")]
        self.assertGreater(len(lines), 8)
        for line in lines:
            if line[0] == "→":
                host.send(line[2:].replace("/home/me/teapot.glb", SCENE).encode() + b"\n")
                continue
            example = json.loads(line[2:].replace(", ...}", "}").replace("{...}", "{}"))
            if example.get("event") == "hello":
                self.assertEqual(example.keys(), host.hello.keys())
            elif example.get("event") != "loading":  # this event may occur any number of times
                fixed = {key: example[key] for key in ("event", "id", "ok", "edit") if key in example}
                host.receive(lambda m: fixed.items() <= m.items() and example.keys() <= m.keys())
        self.assertEqual(host.end()[0], 0)

    def test_scene(self):
        scene = self.opened()[1]["scene"]
        self.assertTrue(scene["materials"] and scene["instances"] and scene["radius"] > 0)
        self.assertGreater(math.dist(scene["view"]["look_from"], scene["view"]["look_at"]), 0)

    def test_edits_of_open_hold_from_the_first_picture_on(self):
        camera = {"look_from": [1.5, 1.2, 4], "look_at": [0, 1, 0], "fov_y": 45}
        host, answer = self.opened(edits={"camera": camera})
        view = answer["scene"]["view"]
        self.assertLess(math.dist(view["look_from"], camera["look_from"]), 1e-6)
        self.assertGreaterEqual(host.picture(lambda p: True)[0]["edit"], answer["edit"])

    def test_size(self):
        host, _ = self.opened()
        before, _ = host.finished()
        old = host.memory
        edit = host.request("settings", settings={"size": "96x64"})["edit"]
        picture, pixels = host.finished(edit)
        self.assertGreater(picture["segment"], before["segment"])
        self.assertEqual(len(pixels), 96 * 64 * 16)
        old[0:16]  # must not crash, because the old mapping stays valid

    def test_display_and_overlay(self):
        host, _ = self.opened()
        edit = host.request("settings", settings={"format": "display"})["edit"]
        picture, pixels = host.finished(edit)
        self.assertEqual((picture["format"], len(pixels)), ("display", 64 * 48 * 4))
        host.request("settings", settings={"format": None, "overlay": "samples"})
        picture, pixels = host.picture(lambda p: p["legend"])
        self.assertEqual((picture["format"], len(pixels)), ("display", 64 * 48 * 4))

    def test_pause(self):
        host, _ = self.opened()
        host.finished()
        host.request("settings", settings={"paused": True})
        edit = host.request("settings", settings={"spp": 100000})["edit"]
        host.picture(lambda p: p["edit"] >= edit)  # the paused session shows one picture of the edit
        time.sleep(0.3)
        host.request("settings", settings={"exposure": 1})  # makes the session show the same picture again
        first = host.picture(lambda p: True)[0]["samples"]
        time.sleep(0.3)
        host.request("settings", settings={"exposure": 2})
        self.assertEqual(host.picture(lambda p: True)[0]["samples"], first)
        host.request("settings", settings={"paused": None})
        host.picture(lambda p: p["samples"] > first)

    def test_picture_stays_until_next(self):
        host, _ = self.opened("--spp", "4096")
        while (message := host.read()).get("event") != "picture":
            pass
        pixels = host.map(message)
        time.sleep(0.5)
        self.assertEqual(pixels, host.map(message))
        host.send_command("next", after=message["number"])
        while (later := host.read()).get("event") != "picture":
            pass
        self.assertEqual(later["number"], message["number"] + 1)
        time.sleep(0.3)
        self.assertEqual(pixels, host.map(message))

    def test_memory_cannot_be_written(self):
        host, _ = self.opened()
        picture, _ = host.finished()
        with contextlib.suppress(PermissionError):  # only root can open the memory for writing
            with open(picture["memory"], "r+b", buffering=0) as file:
                with self.assertRaises(OSError):
                    file.write(b"x")
                with self.assertRaises(OSError):
                    file.truncate(0)
                with self.assertRaises(OSError):
                    mmap.mmap(file.fileno(), picture["bytes"], access=mmap.ACCESS_WRITE)

    def test_second_scene(self):
        host, first = self.opened()
        host.finished()
        other = os.path.join(SCENES, "spheres.glb")
        answer = host.request("open", scene=other)
        self.assertGreater(answer["edit"], first["edit"])
        host.finished(answer["edit"])
        # After a bad scene is refused, the scene that was open stays open.
        refused = host.request("open", scene=os.path.join(SCENES, "none.glb"))
        self.assertFalse(refused["ok"])
        self.assertIn("none.glb", refused["error"])
        host.finished(host.request("camera", camera={"look_from": [0, 1, 5], "look_at": [0, 0, 0]})["edit"])

    def test_newest_open_counts(self):
        host = self.host("--size", "64x48", "--spp", "1")
        for number in (1, 2, 3):
            host.send_command("open", id=number, scene=SCENE)
        host.receive(lambda m: m.get("id") == 3 and m["ok"])
        refused = [m["id"] for m in host.events if m.get("ok") is False]
        self.assertEqual(refused, [1, 2])

    def test_example(self):
        out = os.path.join(self.folder.name, "last.pfm")
        example = subprocess.run([sys.executable, EXAMPLE, SCENE, out, PROGRAM, "64x48", "4"], check=True,
                               stdout=subprocess.PIPE, timeout=TIMEOUT_S).stdout.decode()
        self.assertEqual(example.count("degrees"), 36)
        self.assertEqual(os.path.getsize(out), len("PF\n64 48\n-1\n") + 64 * 48 * 12)
        with open(EXAMPLE) as file:
            self.assertLessEqual(len(file.readlines()), 60)


class Refusals(SessionTest):
    def refused(self, host, words, do, **members):
        answer = host.request(do, **members)
        self.assertFalse(answer["ok"], answer)
        self.assertIn(words, answer["error"])
        self.assertNotIn("\n", answer["error"])

    def test_before_open(self):
        host = self.host()
        self.refused(host, "no scene is open", "camera", camera=None)
        self.refused(host, "no scene is open", "edits", edits={})
        self.refused(host, "no picture", "save", file=os.path.join(self.folder.name, "x.png"))
        self.refused(host, "there is no picture 7", "next", after=7)
        self.assertTrue(host.request("settings", settings={"spp": 4})["ok"])
        self.assertTrue(host.request("cancel")["ok"])

    def test_commands(self):
        host = self.host()
        self.refused(host, "did you mean 'settings'", "setings")
        self.refused(host, "scene", "open")
        self.refused(host, "member", "open", scene=SCENE, edit={})
        self.refused(host, "expected", "open", scene=[])
        self.refused(host, "control", "open", scene="a\0b.glb")
        self.refused(host, "expected", "next", after=-1)
        self.refused(host, "expected", "settings", settings=[1])
        host.send(b'{"id": [1], "do": "quit"}\n{"id": 1}\n')
        self.assertFalse(host.receive(lambda m: "ok" in m)["ok"])
        self.assertIn("do", host.receive(lambda m: "ok" in m)["error"])

    def test_settings_as_the_command_line_says(self):
        host = self.host()
        for option, value in (("spp", "0"), ("spp", "many"), ("sampler", "sobel"), ("size", "0x5"), ("threads", "0"),
                              ("filter-radius", "nan"), ("overlay", "errors"), ("env-strength", "-1")):
            output = subprocess.run([PROGRAM, "session", f"--{option}={value}"], stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(output.returncode, 2)
            answer = host.request("settings", settings={option: value})
            self.assertFalse(answer["ok"], option)
            self.assertEqual("emberline: error: " + answer["error"], output.stderr.decode().strip())
        self.refused(host, "did you mean '--spp'", "settings", settings={"sppp": 3})
        for name in ("", "help", "-", "--spp", "settings=x", "spp=4 --seed", "Spp"):
            self.refused(host, "", "settings", settings={name: "1"})
        self.refused(host, "neither true nor false", "settings", settings={"transparent": "maybe"})
        self.refused(host, "--spp", "settings", settings={"spp": True})
        self.assertTrue(host.request("settings", settings={"transparent": True, "paused": False, "lenient": "no"})["ok"])
        # If one setting is refused, the other settings of its command have no effect either.
        self.refused(host, "--seed", "settings", settings={"size": "8x8", "seed": -1})

    def test_edits(self):
        host, _ = self.opened()
        self.refused(host, "no material 99", "edits", edits={"materials": [{"index": 99, "roughness": 1}]})
        self.refused(host, "roughness", "edits", edits={"materials": [{"index": 0, "roughness": "x"}]})
        self.refused(host, "member", "edits", edits={"material": []})
        self.refused(host, "look_at", "camera", camera={"look_from": [0, 0, 1]})
        self.refused(host, "matrix", "camera", camera={"matrix": [1] * 15})
        self.refused(host, "matrix", "camera", camera={"matrix": [0] * 16})
        self.refused(host, "matrix", "camera", camera={"matrix": [1] * 16, "up": [0, 1, 0]})
        self.refused(host, "camera", "camera", camera=[])
        host.finished(host.request("edits", edits={"materials": [{"index": 0, "roughness": 0.5}]})["edit"])

    def test_missing_environment_is_a_problem(self):
        host, _ = self.opened()
        self.assertTrue(host.request("edits", edits={"environment": {"file": "/none.hdr"}})["ok"])
        self.assertIn("/none.hdr", host.receive(lambda m: m.get("event") == "problem" and m["text"])["text"])
        edit = host.request("edits", edits={"environment": None})["edit"]
        host.finished(edit)
        self.assertEqual([m["text"] for m in host.events if m.get("event") == "problem"][-1], "")

    def test_huge_size_is_a_problem(self):
        host, _ = self.opened("--memory-limit", "300M")
        host.finished()
        host.request("settings", settings={"size": "65536x65536"})
        problem = host.receive(lambda m: m.get("event") == "problem" and m["text"])["text"]
        self.assertIn("65536", problem)
        host.finished(host.request("settings", settings={"size": "32x32"})["edit"])


class Ends(SessionTest):
    def expect_end(self, data, code, words):
        host = self.host()
        exit_code, output, complaints = host.end(data)
        self.assertEqual((exit_code, len(complaints)), (code, 1), complaints)
        self.assertIn(words, complaints[0])
        return output

    def test_quit(self):
        host, _ = self.opened("--spp", "100000")
        self.assertTrue(host.request("quit")["ok"])
        self.assertEqual(host.end()[0::2], (0, []))

    def save_commands(self, *files):
        """Returns the lines of commands that save to these files and then quit."""
        lines = [{"do": "save", "id": f"save {file}", "file": os.path.join(self.folder.name, file)} for file in files]
        return b"".join(json.dumps(line).encode() + b"\n" for line in [*lines, {"do": "quit", "id": "quit"}])

    def test_saves_before_quit_are_told(self):
        """Sends all commands at once, as a script would. The session must answer each save, and a failed save must
        affect the exit code."""
        for files, code, complaint in (
            (["a.exr", "b.png", "c.json"], 0, None),
            (["d.exr", "no/e.exr", "f.png"], 1, "no/e.exr"),
            (["g.gif"], 1, "g.gif"),
            (["no/h.json", "no/i.png"], 1, "(and 1 more could not be saved)"),
        ):
            with self.subTest(files):
                host, _ = self.opened()
                host.finished()
                exit_code, output, complaints = host.end(self.save_commands(*files))
                answers = {message["id"]: message["ok"] for message in output if "ok" in message}
                written = [file for file in files if os.path.exists(os.path.join(self.folder.name, file))]
                self.assertEqual(answers, {"quit": True, **{f"save {file}": file in written for file in files}})
                self.assertEqual((exit_code, len(complaints)), (code, 1 if complaint else 0), complaints)
                self.assertEqual(len(written), len(files) if code == 0 else 2 if "d.exr" in files else 0)
                if complaint:
                    self.assertIn(complaint, complaints[0])

    def test_a_save_that_is_refused_counts_as_failed(self):
        host = self.host()
        exit_code, output, complaints = host.end(self.save_commands("a.exr"))
        self.assertEqual((exit_code, len(complaints)), (1, 1), complaints)
        self.assertIn("no picture", complaints[0])
        host = self.host()
        exit_code, output, complaints = host.end(b'{"id":{},"do":"save","file":"q.exr"}\n{"do": "quit"}\n')
        self.assertEqual((exit_code, len(complaints)), (1, 1), complaints)
        host = self.host()
        command = json.dumps({"id": 1, "do": "open", "scene": SCENE}).encode() + b"\n"
        exit_code, output, _ = host.end(command + b'{"do": "quit"}\n')
        self.assertEqual(exit_code, 0)
        self.assertEqual([message["id"] for message in output if "ok" in message], [1])

    def test_saves_before_the_end_without_quit(self):
        host, _ = self.opened()
        host.finished()
        exit_code, output, complaints = host.end(self.save_commands("a.exr", "no/b.exr").replace(b"quit", b"cancel"))
        self.assertEqual((exit_code, len(complaints)), (3, 1), complaints)
        self.assertEqual({m["id"]: m["ok"] for m in output if "ok" in m and "save" in m["id"]},
                         {"save a.exr": True, "save no/b.exr": False})

    def test_what_a_writer_leaves_in_the_pipe_is_carried_out(self):
        """Closes the pipe while the host has not read the answers, so that the session has stopped reading commands."""
        for file, code in (("a.exr", 0), ("no/b.exr", 1)):
            with self.subTest(file):
                host, _ = self.opened()
                host.finished()
                fcntl.fcntl(host.process.stdin, fcntl.F_SETPIPE_SZ, 1 << 20)
                line = b'{"id": "' + b"x" * 900 + b'", "do": "cancel"}\n'
                host.send(800 * line + self.save_commands(file))
                time.sleep(0.3)
                self.assertIsNone(host.process.poll())
                host.process.stdin.close()
                self.assertTrue(wait_until(lambda: host.process.poll() is not None))
                self.assertEqual(host.process.returncode, code)
                self.assertEqual(os.path.exists(os.path.join(self.folder.name, file)), code == 0)

    def test_a_slow_reader_gets_all(self):
        host, _ = self.opened()
        host.finished()
        host.send(100 * (b'{"id": "' + b"x" * 900 + b'", "do": "cancel"}\n') + self.save_commands("no/a.exr"))
        output = b""
        while chunk := os.read(host.process.stdout.fileno(), 4096):
            output += chunk
            time.sleep(0.1)
        self.assertTrue(b'"id":"save no/a.exr","ok":false' in output)
        self.assertEqual(host.process.wait(), 1)

    def test_nonsense(self):
        output = self.expect_end(b"nonsense\n", 3, "line 1")
        self.assertEqual(output[-1]["event"], "error")
        for data in (b"[]\n", b"7\n", b"\n", b"{\n", b'{"do": NaN}\n', b'{"do": 1e999}\n', b"\xff\xfe\n", b"\0\0\0\n",
                     b'{"do": "quit", "do": "quit"}\n', b'{"a": ' + b"[" * 100000 + b"\n"):
            self.expect_end(data, 3, "line 1")

    def test_nonsense_ends_it_at_once(self):
        host, _ = self.opened("--spp", "100000")
        host.send(b"nonsense\n")
        self.assertTrue(wait_until(lambda: host.process.poll() is not None))
        self.assertEqual(host.process.returncode, 3)

    def test_half_a_line(self):
        self.expect_end(b'{"do": "qu', 3, "in the middle of a line")
        self.expect_end(b"", 3, "without \"quit\"")

    def test_line_without_end(self):
        host = self.host()
        chunk, sent = b"x" * (1 << 20), 0
        while sent < 100 and host.process.poll() is None:
            host.send(chunk)
            sent += 1
        self.assertTrue(wait_until(lambda: host.process.poll() is not None))
        self.assertEqual(host.process.returncode, 3)
        self.assertIn(b"4 MiB", host.process.stderr.read())

    def test_standard_output_is_closed(self):
        host, _ = self.opened("--spp", "100000")
        host.process.stdout.close()
        self.assertTrue(wait_until(lambda: host.process.poll() is not None))
        self.assertEqual(host.process.returncode, 1)
        self.assertEqual(len(host.process.stderr.read().splitlines()), 1)

    def test_killed_host(self):
        code = ("import subprocess, sys, time\n"
                f"p = subprocess.Popen([{PROGRAM!r}, 'session', '--spp', '100000'], stdin=subprocess.PIPE)\n"
                f"p.stdin.write(b'{{\"do\": \"open\", \"scene\": \"{SCENE}\"}}\\n'); p.stdin.flush()\n"
                "print(p.pid, flush=True); time.sleep(600)\n")
        host = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        messages = iter(host.stdout.readline, b"")
        pid = None
        for line in messages:
            if line.strip().isdigit():
                pid = int(line)
            elif json.loads(line).get("event") == "picture":
                path = json.loads(line)["memory"]
                break
        self.assertTrue(os.path.exists(path))
        host.send_signal(signal.SIGKILL)
        host.wait()

        def gone():
            try:
                with open(f"/proc/{pid}/stat") as file:
                    return file.read().rsplit(")", 1)[1].split()[0] == "Z"
            except FileNotFoundError:
                return True
        self.assertTrue(wait_until(gone))
        host.stdout.close()

    def test_host_that_does_not_read(self):
        """Sends commands without reading the answers. The session must then stop reading commands, and must neither
        grow nor hang."""
        host, _ = self.opened("--spp", "100000")
        os.set_blocking(host.process.stdin.fileno(), False)
        line, sent, end = b'{"id": "' + b"x" * 900 + b'", "do": "cancel"}\n', 0, time.monotonic() + 3
        while time.monotonic() < end and sent < 32 << 20:
            try:
                sent += os.write(host.process.stdin.fileno(), line)
            except BlockingIOError:
                time.sleep(0.02)
        self.assertLess(sent, 4 << 20)
        with open(f"/proc/{host.process.pid}/status") as file:
            status = dict(line.split(":", 1) for line in file)
        self.assertLess(int(status["VmRSS"].split()[0]), 2 << 20)
        self.assertIsNone(host.process.poll())
        host.process.stdin.close()
        self.assertTrue(wait_until(lambda: host.process.poll() is not None))
        self.assertEqual(host.process.returncode, 3)

    def test_stop_signal(self):
        host, _ = self.opened("--spp", "100000")
        host.process.send_signal(signal.SIGTERM)
        self.assertTrue(wait_until(lambda: host.process.poll() is not None))
        self.assertEqual(host.process.returncode, 130)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
