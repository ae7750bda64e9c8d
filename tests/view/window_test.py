"""Tests the window as a user would, with real key and mouse events on a virtual screen."""
import json
import pathlib
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest

import display as screens

BINARY, SCENES = None, None
SKIPPED = 77  # the exit code with which a test tells ctest that it is skipped
SIZE = (160, 90)


def scene(name="cornell_box"):
    return SCENES / f"{name}.glb"


def small(*more, driver="bisection", spp=4):
    """Returns arguments for a frame that finishes within a moment."""
    words = [scene(), "--size", f"{SIZE[0]}x{SIZE[1]}", "--driver", driver]
    return words + (["--spp", spp] if spp else []) + list(more)


def with_camera(source, target, camera, scale):
    """Copies a scene file. The copy has this camera, and its camera node has this scale."""
    data = source.read_bytes()
    length, = struct.unpack_from("<I", data, 12)
    gltf = json.loads(data[20:20 + length])
    gltf["cameras"] = [camera]
    next(n for n in gltf["nodes"] if "camera" in n)["scale"] = scale
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length:]
    target.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
                       + text + rest)


class WindowTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.display = screens.Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.close()

    def window(self, *words, **options):
        window = screens.Window(self.display, BINARY, *words, **options)
        self.addCleanup(window.close)
        return window

    def finished(self, *words, **options):
        """Opens a window, waits until its frame is finished, and gives it the keyboard focus."""
        window = self.window(*(words or small()), **options)
        window.wait_until_finished()
        window.focus()
        return window

    shared_window = None

    def shared(self):
        """Returns one window for all tests that only need a finished frame. They must leave it unedited and running."""
        if self.shared_window is None or self.shared_window.process.poll() is not None:
            type(self).shared_window = screens.Window(self.display, BINARY, *small())
            self.addClassCleanup(self.shared_window.close)
            self.shared_window.wait_until_finished()
        self.shared_window.focus()
        self.addCleanup(self.unedited, self.shared_window)
        return self.shared_window

    def unedited(self, window):
        since = window.mark()
        window.key("r")
        if window.last("edits") and window.last("edits")["camera"]:
            window.wait_for("edits", lambda e: e["camera"] is None, since)

    def rendered(self, folder, suffix, *more):
        file = folder / f"reference.{suffix}"
        subprocess.run([BINARY, "render", scene(), "--size", f"{SIZE[0]}x{SIZE[1]}", "--spp", "4", "-q",
                        "-o", str(file), *map(str, more)], check=True)
        return file

    def values_of(self, exr):
        """Returns R, G and B of each pixel, by its (x, y)."""
        text = subprocess.run(["oiiotool", "--dumpdata", str(exr)], check=True, capture_output=True, text=True).stdout
        found = re.findall(r"Pixel \((\d+), (\d+)\): (\S+) (\S+) (\S+)", text)
        self.assertEqual(len(found), SIZE[0] * SIZE[1])
        return {(int(x), int(y)): tuple(map(float, rgb)) for x, y, *rgb in found}

    # ---- the picture

    def raw(self, window):
        """Turns off denoising in the window."""
        since = window.mark()
        window.key("n")
        window.wait_for("picture", lambda e: not e["denoised"], since)
        return window

    def test_shows_what_render_writes(self):
        window = self.raw(self.finished())
        since = window.mark()
        window.key("z")  # shows the picture at a zoom of 1
        window.wait_for("placed", lambda e: e["zoom"] == 1, since)
        width, height, rows = window.screenshot()
        self.assertEqual((width, height), (1000, 640))
        picture = window.last("placed")
        self.assertEqual(picture["zoom"], 1)
        left, top = (int(value) for value in picture["at"])
        shown = [rows[top + y][3 * left:3 * (left + SIZE[0])] for y in range(SIZE[1])]
        _, _, expected = screens.read_png(self.rendered(window.folder, "png"))
        worst = max(abs(a - b) for s, e in zip(shown, expected) for a, b in zip(s, e))
        self.assertLessEqual(worst, 1, "the window's pixels are not those of `render`")
        self.assertGreater(len({bytes(r[3 * x:3 * x + 3]) for r in shown for x in range(SIZE[0])}), 1000)

    def test_value_under_the_cursor_is_the_films(self):
        window = self.finished()
        exr = self.rendered(window.folder, "exr")
        values = self.values_of(exr)
        for x, y in ((80, 45), (31, 60), (120, 20)):
            since = window.mark()
            window.move_to_pixel(x, y)
            time.sleep(0.3)
            window.key("ctrl+c")
            event = window.wait_for("pixel", since=since)
            self.assertEqual((event["x"], event["y"]), (x, y))
            for event_value, value in zip(event["rgb"], values[x, y], strict=True):
                self.assertAlmostEqual(event_value, value, delta=1e-5 * max(1, abs(value)))
            self.assertTrue(event["known"])
            self.assertEqual(event["samples"], 4)

    def test_explains_a_pixel(self):
        window = self.finished(*small(driver="adaptive", spp=24))
        window.move_to_pixel(120, 20)
        since = window.mark()
        window.key("F3")
        first = window.wait_for("explanation", since=since)
        self.assertEqual((first["x"], first["y"]), (120, 20))
        self.assertIn("ended by --spp", first["text"])
        self.assertNotIn("rounds", first["text"])
        since = window.mark()
        window.key("F5")
        window.wait_for("explanation", lambda e: "ended by" not in e["text"], since)
        window.wait_for("explanation", lambda e: "ended by --spp" in e["text"] and "rounds\n" in e["text"], since)
        # The explanation stays with its pixel until another pixel is clicked.
        since = window.mark()
        window.move_to_pixel(150, 10)
        window.screenshot()  # once it is saved, the window has handled the move
        self.assertFalse([e for e in window.events[since:] if e["event"] == "explanation"])
        window.display.xdotool("click", 1)
        event = window.wait_for("explanation", since=since)
        self.assertEqual((event["x"], event["y"]), (150, 10))
        before = window.screenshot()
        window.key("F3")
        time.sleep(0.3)
        self.assertNotEqual(window.screenshot()[2], before[2])

    def test_a_click_selects_the_material(self):
        window = self.shared()
        since = window.mark()
        window.move_to_pixel(80, 85)  # this pixel shows the floor
        window.display.xdotool("click", 1)
        self.assertGreaterEqual(window.wait_for("select", since=since)["material"], 0)

    def test_overlay_appears_and_goes(self):
        window = self.finished()
        before = window.screenshot()
        since = window.mark()
        window.key("o")
        self.assertIn("samples", window.wait_for("picture", lambda e: e["legend"], since)["legend"])
        self.assertNotEqual(window.screenshot()[2], before[2])
        for _ in range(6):
            window.key("o")
        since = window.mark()
        window.key("F5")
        self.assertEqual(window.wait_until_finished(since)["legend"], "")

    def halves(self, window):
        """Returns the mean brightness of the left half and of the right half of the picture."""
        left, top = (int(value) for value in window.last("placed")["at"])
        zoom = window.last("placed")["zoom"]
        _, _, rows = window.screenshot()
        def mean(x0, x1):
            spans = [rows[top + int(y * zoom)][3 * (left + int(x0 * zoom)):3 * (left + int(x1 * zoom))]
                     for y in range(30, SIZE[1] - 20)]  # these rows contain no labels or notes
            return sum(sum(s) for s in spans) / sum(len(s) for s in spans)
        return mean(10, SIZE[0] // 2 - 10), mean(SIZE[0] // 2 + 10, SIZE[0] - 10)

    def test_both_sides_of_a_wipe_have_the_exposure_of_now(self):
        window = self.finished()
        window.key("b")
        window.key("v")
        time.sleep(0.3)
        before = self.halves(window)
        since = window.mark()
        for _ in range(4):
            window.key("bracketright")
        window.wait_for("kept", lambda e: e["graded_as_a"], since)
        time.sleep(0.5)
        after = self.halves(window)
        for half in (0, 1):
            self.assertGreater(after[half], before[half] + 10, f"half {half} of {before}, {after}")

    def test_a_wipe_shows_both_pictures(self):
        window = self.finished()
        before = window.screenshot()[2]
        window.key("b")
        since = window.mark()
        window.key("o")
        window.wait_for("picture", lambda e: e["legend"], since)
        window.key("v")
        time.sleep(0.3)
        after = window.screenshot()[2]
        left, top = (int(value) for value in window.last("placed")["at"])
        zoom = window.last("placed")["zoom"]

        def difference(x0, x1):
            span = slice(3 * (left + int(x0 * zoom)), 3 * (left + int(x1 * zoom)))
            rows = range(top + int(20 * zoom), top + int(70 * zoom))  # these rows contain no labels or notes
            pairs = [pair for y in rows for pair in zip(before[y][span], after[y][span])]
            return sum(abs(a - b) for a, b in pairs) / len(pairs)
        self.assertGreater(difference(10, SIZE[0] // 2 - 10), 20)  # this half shows the overlay
        self.assertLess(difference(SIZE[0] // 2 + 10, SIZE[0] - 10), 1)  # this half shows the earlier picture

    def test_pictures_are_denoised_from_the_first_on(self):
        window = self.finished(*small(driver="live", spp=4))
        pictures = [e for e in window.events if e["event"] == "picture" and e["samples"] > 0]
        self.assertTrue(all(e["denoised"] for e in pictures))
        clean = window.screenshot()[2]
        edit = window.last("picture")["edit"]
        self.raw(window)
        time.sleep(0.3)
        noisy = window.screenshot()[2]
        self.assertEqual(window.last("picture")["edit"], edit)

        def roughness(rows):
            left, top = (int(value) for value in window.last("placed")["at"])
            zoom = window.last("placed")["zoom"]
            spans = [rows[top + int(y * zoom)][3 * (left + int(50 * zoom)):3 * (left + int(110 * zoom))]
                     for y in range(10, 60)]
            return sum(abs(a - b) for s in spans for a, b in zip(s, s[3:])) / len(spans)
        self.assertLess(roughness(clean), 0.7 * roughness(noisy))

    def test_a_wipe_between_denoised_and_raw(self):
        window = self.finished()
        clean = window.screenshot()[2]
        since = window.mark()
        window.key("shift+v")
        window.wait_for("picture", since=since)
        time.sleep(0.3)
        wiped = window.screenshot()[2]
        self.raw(window)  # this also ends the wipe
        time.sleep(0.3)
        noisy = window.screenshot()[2]
        left, top = (int(value) for value in window.last("placed")["at"])
        zoom = window.last("placed")["zoom"]

        def side(rows, x0, x1):
            span = slice(3 * (left + int(x0 * zoom)), 3 * (left + int(x1 * zoom)))
            return [bytes(rows[top + int(y * zoom)][span]) for y in range(30, 60)]  # without labels and notes
        first, second = (10, SIZE[0] // 2 - 10), (SIZE[0] // 2 + 10, SIZE[0] - 10)
        self.assertEqual(side(wiped, *first), side(clean, *first))
        self.assertEqual(side(wiped, *second), side(noisy, *second))
        self.assertNotEqual(side(clean, *second), side(noisy, *second))

    def test_live_driver_goes_on_with_adaptive_sampling(self):
        # The picture is so large that the window draws it at least once before bisection ends.
        window = self.window(scene(), "--size", "480x300", "--driver", "live")
        window.wait_for("picture", lambda e: e["driver"] == "bisection")
        window.wait_for("picture", lambda e: e["driver"] == "adaptive" and e["complete"])
        window.focus()
        self.assertEqual(window.end(), 0)

    def test_buckets_are_outlined_and_not_in_the_pixels(self):
        window = self.window(*small("--bucket-size", 16, driver="bucket", spp=96))
        window.wait_for("picture", lambda e: e["buckets"] > 0)
        window.wait_until_finished()
        self.assertEqual(window.last("picture")["buckets"], 0)

    def test_a_drag_shows_pictures_before_there_is_a_bucket(self):
        window = self.window(*small("--bucket-size", 160, driver="bucket", spp=16384))
        window.wait_for("picture", lambda e: e["buckets"] > 0)  # the frame's only bucket takes more than a minute
        window.focus()
        since = window.mark()
        window.drag((80, 20), steps=40)
        edited = window.wait_for("edit", since=since)["edit"]
        picture = window.wait_for("picture", lambda e: e["edit"] >= edited, since, seconds=20)
        self.assertEqual((picture["driver"], picture["filled"], picture["complete"]), ("bisection", True, False))

    # ---- input

    def test_orbit_and_one_undo(self):
        window = self.finished()
        before = window.last("picture")["edit"]
        start = window.screenshot()[2]
        since = window.mark()
        window.drag((80, 20), steps=40)
        last = window.wait_until_finished(since)
        self.assertGreater(last["edit"], before)
        self.assertNotEqual(self.picture_rows(window, window.screenshot()), self.picture_rows(window, (0, 0, start)))
        self.assertIsNotNone(window.last("edits")["camera"])
        since = window.mark()
        window.key("ctrl+z")
        window.wait_for("edits", lambda e: e["camera"] is None, since)
        window.wait_until_finished(since)
        self.assertEqual(self.picture_rows(window, window.screenshot()), self.picture_rows(window, (0, 0, start)))
        since = window.mark()
        window.key("ctrl+shift+z")
        window.wait_for("edits", lambda e: e["camera"] is not None, since)

    def picture_rows(self, window, shot):
        """Returns rows of the picture without its edges and without the notes at the bottom."""
        picture = window.last("placed")
        left, top = (int(value) for value in picture["at"])
        zoom = picture["zoom"]
        return [shot[2][top + int(y * zoom)][3 * (left + 10):3 * (left + 300)] for y in range(5, 45)]

    def test_keys_fly_and_reset(self):
        window = self.shared()
        since = window.mark()
        window.display.xdotool("keydown", "w", "sleep", "0.4", "keyup", "w")
        window.wait_for("edits", lambda e: e["camera"] is not None, since)
        since = window.mark()
        window.key("r")
        window.wait_for("edits", lambda e: e["camera"] is None, since)

    def test_wheel_dollies_and_control_zooms(self):
        window = self.shared()
        since = window.mark()
        window.move_to_pixel(80, 45)
        window.display.xdotool("click", 4)
        window.wait_for("edits", lambda e: e["camera"] is not None, since)
        zoom = window.last("placed")["zoom"]
        since = window.mark()
        window.display.xdotool("keydown", "ctrl", "click", 4, "keyup", "ctrl")
        window.wait_for("placed", lambda e: e["zoom"] > zoom, since)

    def test_region_and_pause(self):
        window = self.shared()
        since = window.mark()
        window.drag((60, 40), key="ctrl")
        region = window.wait_for("settings", lambda e: e["region"], since)["region"]
        self.assertEqual(region[:2], [80, 45])
        since = window.mark()
        window.key("Escape")
        window.wait_for("settings", lambda e: not e["region"], since)
        window.key("space")
        window.wait_for("settings", lambda e: e["paused"], since)
        since = window.mark()
        window.key("space")
        window.wait_for("settings", lambda e: not e["paused"], since)

    # ---- animation

    def blade(self):
        return self.finished(scene("moving_blade"), *small()[1:])

    def test_steps_through_an_animation(self):
        window = self.blade()
        pictures = [window.screenshot()[2]]
        for key, expected in (("period", 1 / 24), ("period", 2 / 24), ("comma", 1 / 24)):
            since = window.mark()
            window.key(key)
            event = window.wait_for("edits", lambda e: e["time"] is not None, since)
            self.assertAlmostEqual(event["time"], expected, delta=1e-9)
            window.wait_until_finished(since)
            pictures.append(window.screenshot()[2])
        self.assertNotEqual(pictures[0], pictures[2])
        since = window.mark()
        window.key("ctrl+z", "ctrl+z", "ctrl+z")
        window.wait_for("edits", lambda e: e["time"] is None, since)

    def test_plays_and_stops(self):
        window = self.blade()
        since = window.mark()
        window.key("k")
        first = window.wait_for("edits", lambda e: e["time"], since)["time"]
        window.wait_for("edits", lambda e: e["time"] > first, since)
        window.key("k")
        window.wait_until_finished(since)
        at = window.mark()
        time.sleep(0.5)
        self.assertFalse([e for e in window.events[at:] if e["event"] == "edits"])
        since = window.mark()  # the whole playback is one undo step
        window.key("ctrl+z")
        window.wait_for("edits", lambda e: e["time"] is None, since)

    def test_a_scene_without_animations_has_no_time(self):
        window = self.shared()
        since = window.mark()
        window.key("k", "period")
        window.drag((-60, 10))
        event = window.wait_for("edits", since=since)
        self.assertIsNone(event["time"])

    def window_of_a_copy(self):
        """Opens a window with a copy of a scene. Tests may replace the copy, and may save edits beside it."""
        box = pathlib.Path(self.window_folder()) / "box.glb"
        shutil.copy(scene(), box)
        window = self.window(box, *small()[1:])
        window.wait_until_finished()
        window.focus()
        return box, window

    def test_saves_edits_that_render_takes(self):
        box, window = self.window_of_a_copy()
        since = window.mark()
        window.drag((-60, 10))
        window.wait_until_finished(since)
        self.expect_saved_edits_to_render_alike(window, box)

    def expect_saved_edits_to_render_alike(self, window, box):
        since = window.mark()
        window.key("ctrl+s")
        window.wait_for("message", lambda e: "Edits saved" in e["text"], since)
        edits = box.with_suffix(".edits.json")
        self.assertTrue(edits.exists())
        exr = window.folder / "edited.exr"
        subprocess.run([BINARY, "render", str(box), "--size", "160x90", "--spp", "4", "-q", "--edits", str(edits),
                        "-o", str(exr)], check=True)
        window.move_to_pixel(70, 50)
        time.sleep(0.3)
        since = window.mark()
        window.key("ctrl+c")
        event = window.wait_for("pixel", since=since)
        for event_value, value in zip(event["rgb"], self.values_of(exr)[70, 50], strict=True):
            self.assertAlmostEqual(event_value, value, delta=1e-5 * max(1, abs(value)))

    def test_saving_replaces_nothing_unasked(self):
        box, window = self.window_of_a_copy()
        mine = box.with_suffix(".edits.json")
        mine.write_text("last week's")
        since = window.mark()
        window.key("ctrl+s")
        event = window.wait_for("message", lambda e: "Edits saved" in e["text"], since)
        self.assertEqual(event["text"], f"Edits saved: {box.with_name('box-2.edits.json')}")
        self.assertEqual(mine.read_text(), "last week's")
        picture = box.with_name("frame.png")
        picture.write_text("last week's")
        since = window.mark()
        self.choose_in_dialog(window, "ctrl+shift+s", picture)
        time.sleep(1)
        self.assertEqual(picture.read_text(), "last week's")
        window.key("Return")  # answers the dialog's question with yes
        window.wait_for("message", lambda e: "Picture saved" in e["text"], since)
        self.assertEqual(screens.read_png(picture)[0], SIZE[0])
        # The window must not overwrite a file that the scene reads, under any name of that file.
        other = box.with_name("other.png")
        other.hardlink_to(box)
        before = box.read_bytes()
        since = window.mark()
        self.choose_in_dialog(window, "ctrl+shift+s", other)
        time.sleep(1)
        window.key("Return")
        event = window.wait_for("message", lambda e: "other.png" in e["text"], since)
        self.assertIn("the scene reads", event["text"])
        self.assertEqual(other.read_bytes(), before)
        for option in ("--journal", "--measure", "--screenshot"):
            run = subprocess.run([BINARY, "view", str(box), option, str(other)], capture_output=True, text=True,
                                 env=self.display.environment, timeout=screens.TIMEOUT_S)
            self.assertEqual((run.returncode, run.stderr.count("\n")), (2, 1), run.stderr)
            self.assertIn("it is the scene", run.stderr)
            self.assertEqual(other.read_bytes(), before)

    def test_a_journal_over_what_the_scene_reads_is_refused(self):
        folder = pathlib.Path(self.window_folder())
        shutil.copy(scene(), folder / "a.glb")
        data = (folder / "a.glb").read_bytes()
        length = int.from_bytes(data[12:16], "little")
        gltf = json.loads(data[20:20 + length])
        gltf["buffers"][0]["uri"] = "a.bin"
        (folder / "a.gltf").write_text(json.dumps(gltf))
        (folder / "a.bin").write_bytes(data[28 + length:])
        before = (folder / "a.bin").read_bytes()
        (folder / "a.png").hardlink_to(folder / "a.bin")
        for option, name in (("--journal", "a.bin"), ("--screenshot", "a.png")):
            run = subprocess.run([BINARY, "view", str(folder / "a.gltf"), *map(str, small()[1:]), "--forget", option,
                                  str(folder / name)], capture_output=True, text=True,
                                 env=self.display.environment, timeout=screens.TIMEOUT_S)
            self.assertEqual(run.returncode, 2, run.stderr)
            self.assertIn("the scene reads", run.stderr)
            self.assertEqual((folder / "a.bin").read_bytes(), before)

    def test_moving_an_orthographic_mirrored_camera_keeps_its_kind(self):
        box = pathlib.Path(self.window_folder()) / "flat.glb"
        with_camera(scene(), box, {"type": "orthographic", "name": "flat", "orthographic": {
            "xmag": 270, "ymag": 270, "znear": 0.1, "zfar": 5000}}, [-1, 1, 1])
        window = self.window(box, *small()[1:])
        window.wait_until_finished()
        window.focus()
        heights = []
        for move in (lambda: window.drag((30, 10)), lambda: window.drag((20, -15), key="shift"),
                     lambda: window.drag((10, 5), button=3), lambda: window.display.xdotool("click", 4),
                     lambda: window.key("f")):
            since = window.mark()
            move()
            event = window.wait_for("edits", lambda e: e["camera"], since)
            window.wait_until_finished(since)
            event = window.last("edits")
            self.assertTrue(event["mirrored"])
            heights.append(event["orthographic_height"])
        self.assertTrue(all(abs(h - 540) < 1e-9 for h in heights[:3]), heights)
        self.assertLess(heights[3], 500)
        since = window.mark()
        window.key("ctrl+z")
        self.assertEqual(window.wait_for("edits", since=since)["orthographic_height"], heights[3])
        since = window.mark()
        window.key("ctrl+1")  # sets a bookmark, to which key 1 returns below
        window.drag((30, 30))
        window.key("f")
        window.wait_for("edits", lambda e: abs(e["orthographic_height"] - heights[4]) < 1e-9, since)
        since = window.mark()
        window.key("1")
        self.assertEqual(window.wait_for("edits", since=since)["orthographic_height"], heights[3])
        window.wait_until_finished(since)
        self.expect_saved_edits_to_render_alike(window, box)
        since = window.mark()
        window.key("r")
        self.assertIsNone(window.wait_for("edits", since=since)["orthographic_height"])

    def test_a_key_changes_the_projection_and_what_is_orbited_keeps_its_size(self):
        window = self.finished()
        since = window.mark()
        window.drag((30, 10))
        window.wait_until_finished(since)
        camera = window.last("edits")["camera"]
        since = window.mark()
        window.key("p")
        flat = window.wait_for("edits", lambda e: e["orthographic_height"], since)
        self.assertEqual(flat["camera"], camera)
        since = window.mark()
        window.key("p")
        deep = window.wait_for("edits", lambda e: not e["orthographic_height"], since)
        for back, there in zip(deep["camera"], camera):
            self.assertAlmostEqual(back, there, delta=1e-6 * 1000)
        since = window.mark()
        window.key("ctrl+z")
        self.assertEqual(window.wait_for("edits", since=since)["orthographic_height"], flat["orthographic_height"])

    def window_folder(self):
        import tempfile
        folder = tempfile.mkdtemp(prefix="emberline-view-")
        self.addCleanup(shutil.rmtree, folder, True)
        return folder

    def open_dialog(self, window, keys):
        since = window.mark()
        window.key(keys)
        window.wait_for("dialog", lambda e: e["asks"], since)

    def choose_in_dialog(self, window, keys, path):
        self.open_dialog(window, keys)
        window.type(str(path))  # this replaces the name that the dialog suggests
        window.key("Return")

    def test_an_environment_can_be_opened_and_taken_back(self):
        window = self.finished()
        start = self.picture_rows(window, window.screenshot())
        since = window.mark()
        self.choose_in_dialog(window, "ctrl+o", SCENES / "dusk.hdr")
        edits = window.wait_for("edits", lambda e: e["environment"], since)
        self.assertEqual(edits["environment"], str(SCENES / "dusk.hdr"))
        window.wait_until_finished(since)
        time.sleep(0.5)  # until the dialog has disappeared
        self.assertNotEqual(self.picture_rows(window, window.screenshot()), start)
        since = window.mark()
        window.key("ctrl+z")
        window.wait_for("edits", lambda e: not e["environment"], since)

    def test_escape_closes_a_dialog_and_nothing_else(self):
        window = self.finished()
        since = window.mark()
        window.drag((60, 40), key="ctrl")
        window.wait_for("settings", lambda e: e["region"], since)
        self.open_dialog(window, "ctrl+o")
        window.type("f")  # is a letter of the file name here
        window.key("Escape")
        time.sleep(0.5)
        since = window.mark()
        window.key("f")  # now shows the whole scene
        window.wait_for("edits", lambda e: e["camera"], since)
        self.assertTrue(window.last("settings")["region"])

    def test_reloading_keeps_the_edits(self):
        box, window = self.window_of_a_copy()
        since = window.mark()
        window.drag((60, 10))
        window.wait_until_finished(since)
        camera = window.last("edits")["camera"]
        materials = window.last("scene")["materials"]
        shutil.copy(scene("spheres"), box)
        since = window.mark()
        window.key("ctrl+r")
        window.wait_for("scene", lambda e: e["materials"] != materials, since)
        self.assertEqual(window.wait_for("edits", since=since)["camera"], camera)
        window.wait_until_finished(since)
        self.assertEqual(window.end(), 0)

    # ---- many events

    def test_storm_of_edits(self):
        window = self.finished()
        generator = random.Random(1)
        since = window.mark()
        for _ in range(4):
            window.drag((generator.randint(-200, 200), generator.randint(-80, 80)), steps=150)
        window.screenshot()  # once it is saved, the window has handled all drags
        edit = window.last("edit")["edit"]
        window.wait_for("picture", lambda e: e["edit"] >= edit and e["finished"], since)
        self.assertEqual(window.end(), 0)

    def test_storm_of_sizes(self):
        window = self.finished()
        number = window.focus()
        generator = random.Random(2)
        words = []
        for _ in range(60):
            words += ["windowsize", number, generator.randint(320, 1200), generator.randint(240, 780)]
        self.display.xdotool(*words)
        self.display.xdotool("windowsize", "--sync", number, 900, 600)
        time.sleep(0.5)
        width, height, _ = window.screenshot()
        self.assertEqual((width, height), (900, 600))
        self.assertEqual(window.end(), 0)

    def test_closing_while_it_loads(self):
        for delay in (0.0, 0.05, 0.2, 0.4):
            window = self.window(scene("teapot"), "--env", SCENES / "studio.hdr", "--size", "1280x720")
            time.sleep(delay)
            self.assertIn(window.end(signal.SIGTERM), (0, 130, -signal.SIGTERM))

    def test_closing_while_it_renders(self):
        window = self.window(scene("teapot"), "--size", "1280x720")
        window.wait_for("picture")
        window.focus()
        self.assertEqual(window.end(), 0)

    # ---- errors

    def test_no_display(self):
        absent = ("DISPLAY", "WAYLAND_DISPLAY", "XDG_RUNTIME_DIR")
        environment = {k: v for k, v in self.display.environment.items() if k not in absent}
        for name in (None, ":919"):
            run = subprocess.run([BINARY, "view", str(scene())], capture_output=True, text=True, timeout=60,
                                 env=dict(environment, **({"DISPLAY": name} if name else {})))
            self.assertEqual(run.returncode, 1)
            self.assertEqual(run.stdout, "")
            self.assertEqual(len(run.stderr.splitlines()), 1, run.stderr)
            self.assertIn("cannot open a window", run.stderr)

    def test_a_bad_scene_leaves_the_old_one_and_says_why(self):
        window = self.finished()
        bad = window.folder / "bad.glb"
        bad.write_bytes(b"not a scene")
        before = window.last("picture")["serial"]
        since = window.mark()
        self.choose_in_dialog(window, "ctrl+o", bad)
        message = window.wait_for("message", lambda e: e["level"] == "error", since)
        self.assertIn("bad.glb", message["text"])
        self.assertGreaterEqual(window.last("picture")["serial"], before)
        self.assertIsNone(next((e for e in window.events[since:] if e["event"] == "scene"), None))
        time.sleep(0.5)  # until the dialog has disappeared, because it has the keyboard focus
        since = window.mark()
        window.key("F5")
        window.wait_until_finished(since)
        self.assertEqual(window.end(), 0)

    def test_a_bad_scene_at_the_start_keeps_the_window_open(self):
        window = self.window("/nonexistent.glb")
        self.assertIn("nonexistent", window.wait_for("message", lambda e: e["level"] == "error")["text"])
        window.focus()
        self.assertEqual(window.end(), 0)

    def test_a_combination_that_makes_no_sense_is_said(self):
        window = self.window(*small("--sampler", "stratified", driver="adaptive"))
        window.wait_for("message", lambda e: e["level"] == "error" and "stratified" in e["text"])
        window.focus()
        self.assertEqual(window.end(), 0)

    # ---- files

    def test_remembers_its_size(self):
        window = self.finished(size=(777, 555))
        config = window.folder / "config" / "emberline" / "view.json"
        self.assertEqual(window.end(), 0)
        self.assertIn('"width": 777', config.read_text())
        self.assertIn("cornell_box.glb", config.read_text())

    def test_a_journal_that_cannot_be_written_is_said_once(self):
        folder = pathlib.Path(self.window_folder())
        run = subprocess.run([BINARY, "view", *map(str, small()), "--journal", "/dev/full", "--screenshot",
                              str(folder / "window.png")], capture_output=True, text=True,
                             env=dict(self.display.environment, XDG_CONFIG_HOME=str(folder)), timeout=screens.TIMEOUT_S)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual(run.stderr.count("stopped writing the journal: cannot write /dev/full"), 1, run.stderr)
        self.assertGreater(screens.read_png(folder / "window.png")[0], 0)

    def test_measures_a_script(self):
        folder = pathlib.Path(self.window_folder())
        script = folder / "script.json"
        script.write_text('[{"at_s": 0.2, "edit": {"orbit": [20, 0]}}, {"at_s": 0.5, "edit": {"light": 0, "intensity": 2}}]')
        window = self.window(*small(spp=None), "--measure", folder / "m.json", "--measure-script", script)
        self.assertEqual(window.process.wait(screens.TIMEOUT_S), 0)
        result = json.loads((folder / "m.json").read_text())
        self.assertTrue(result["complete"])
        self.assertEqual([e["what"] for e in result["edits"]], ["camera", "light"])
        self.assertTrue(all(e["first_picture_ms"] > 0 for e in result["edits"]))
        self.assertGreater(result["idle"]["samples_per_s"], 0)


if __name__ == "__main__":
    BINARY, SCENES = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    absent = screens.missing_programs()
    if absent:
        print(f"NOT RUN: {', '.join(absent)} not installed; ci/setup.sh installs what these tests need")
        sys.exit(SKIPPED)
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
