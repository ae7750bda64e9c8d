"""Checks that errors have the right type and a message of one line, and that no wrong value is accepted."""
import functools
import itertools
import json
import logging
import os
import unittest
from unittest import mock

import numpy as np

import emberline
from support import BOX, ROOT, SMALL, Test, python


# This script uses every member of objects that were never initialised. It runs in a separate process, because it may
# crash.
UNINITIALISED_SCRIPT = """
import copy, pickle, sys, types
import emberline
made = "before its __init__() has run"
for kind in (getattr(emberline, name) for name in sys.argv[1:]):
    tried = 0
    for name, member in vars(kind).items():
        if name in ("__init__", "__doc__", "__module__", "__weakref__", "__reduce__", "__reduce_ex__", "help"):
            continue
        for arguments in ((), ("spp",), ("spp", 1)):
            unmade = kind.__new__(kind)
            try:
                value = getattr(unmade, name)
                value(*arguments) if callable(value) else None
            except TypeError as error:
                assert made in str(error) or "incompatible function arguments" in str(error), (name, error)
                tried += made in str(error)
            else:
                assert False, name
    unmade = kind.__new__(kind)
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
        for call in (lambda: pickle.dumps(unmade, protocol), lambda: unmade.__reduce_ex__(protocol), unmade.__reduce__):
            try:
                call()
            except TypeError as error:
                assert "cannot pickle" in str(error), error
            else:
                assert False, protocol
    print(tried)
"""


class Unmade(Test):
    """Tests objects whose __init__ has not run, and objects that only claim to be ours."""

    def test_nothing_can_be_asked_of_them(self):
        names = ("Settings", "Scene", "Progress", "Picture", "Comparison", "StoredFrame", "StudyTable")
        process = python(UNINITIALISED_SCRIPT, *names)
        out, err = process.communicate(timeout=100)
        self.assertEqual((process.returncode, err), (0, ""))
        for name, tried in zip(names, out.splitlines(), strict=True):
            self.assertGreater(int(tried), 2, name)

    def test_nothing_takes_them(self):
        unmade = {kind: kind.__new__(kind) for kind in (emberline.Settings, emberline.Scene, emberline.Picture)}
        scene, picture = unmade[emberline.Scene], unmade[emberline.Picture]
        settings = unmade[emberline.Settings]
        for call in (
            lambda: emberline.render(scene),
            lambda: emberline.render(self.box, settings),
            lambda: emberline.Settings(settings),
            lambda: emberline.Scene(BOX, settings),
            lambda: emberline.write("a.exr", picture),
            lambda: emberline.compare(picture, picture),
            lambda: emberline.flip(picture, picture),
            lambda: self.box.edit({}, environment=picture),
        ):
            with self.assert_error(TypeError, "before its __init__() has run"):
                call()
        with self.assert_error(TypeError, "not Mock"):
            emberline.compare(mock.Mock(spec=emberline.Picture), np.zeros((2, 2, 3), "float32"))

    def test_subclasses_that_use_themselves_too_early(self):
        class Early(emberline.Scene):
            def __init__(self):
                self.size = self.settings["size"]
                super().__init__(BOX)

        class Presets(emberline.Settings):
            def __init__(self):
                self["spp"] = 3

        class Both(emberline.Settings, emberline.Scene):
            def __init__(self):
                emberline.Settings.__init__(self, spp=3)
                self.lights

        for kind in (Early, Presets, Both):
            with self.assert_error(TypeError, "before its __init__() has run"):
                kind()

        class Late(emberline.Scene):
            def __init__(self):
                super().__init__(BOX, **SMALL)
                self.spp = self.settings["spp"]

        self.assertEqual(Late().spp, "4")


class WrongInput(Test):
    def test_values_that_hold_themselves(self):
        loop = []
        loop.append(loop)
        deep = []
        for _ in range(100000):
            deep = [deep]

        class Item:
            ndim = 0

            def item(self):
                return self

        for value in (loop, [loop], (1, loop), np.array([loop, 1], dtype=object), deep, [[1, 2], 3]):
            with self.assert_error(TypeError, "look-at: expected an array with one dimension"):
                emberline.Settings(look_at=value)
        with self.assertRaises(RecursionError):
            emberline.Settings(spp=Item())
        with self.assert_error(ValueError, "Circular"):
            self.box.edit({"lights": loop})
        with self.assert_error(TypeError, "channels: expected a string, not list"):
            emberline.write("a.exr", np.zeros((2, 2, 1), "float32"), channels=loop)

    def test_bools_sets_and_control_characters(self):
        picture = np.zeros((2, 2, 3), "float32")
        for names in ({"R", "G", "B"}, frozenset("RGB")):
            with self.assert_error(TypeError, "channels: ", "names in order"):
                emberline.write("a.exr", picture, channels=names)
        for name in ("R\n", "R\x7f", "\tR"):
            with self.assert_error(ValueError, "channels", "control characters"):
                emberline.write("a.exr", picture, channels=[name, "G", "B"])
        for name in ("threads", "load_timeout", "memory_limit"):
            with self.assert_error(TypeError, name):
                emberline.Scene(BOX, **{name: True})

    def test_what_the_machine_gives(self):
        """Checks that threads and times have the same ranges as in the command, and that a wrong type causes one
        line."""
        scene = functools.partial(emberline.Scene, BOX)
        render = functools.partial(emberline.render, self.box)
        read = functools.partial(emberline.read, ROOT / "scenes/dusk.hdr")
        for threads in (-1, 4097, 1 << 40):
            for call in (scene, render):
                with self.assert_error(emberline.UsageError, f"threads: {threads}"):
                    call(threads=threads)
        for seconds in (-1, 0, 0.0009, 1e10, float("nan"), float("inf")):
            for call in (scene, read):
                with self.assert_error(emberline.UsageError, "load_timeout", "0.001 to 1000000000"):
                    call(load_timeout=seconds)
        for size in (-1, 0):
            for call in (scene, read):
                with self.assert_error(emberline.UsageError, "memory", str(size)):
                    call(memory_limit=size)
        for wrong, name in ((2.0, "threads"), ("2", "threads"), ("1G", "memory_limit"), (1.5, "memory_limit"),
                            ("1", "load_timeout"), ([], "load_timeout")):
            with self.assert_error(TypeError, name):
                scene(**{name: wrong})
        with self.assert_error(ValueError, "threads"):
            scene(threads=1 << 100)
        render(threads=np.int32(2))
        scene(threads=4096, load_timeout=np.float32(60), memory_limit=np.int64(1 << 32))

    def test_one_hierarchy(self):
        for kind in (emberline.UsageError, emberline.InputError, emberline.RenderError):
            self.assertEqual(kind.__bases__, (emberline.Error,))
            self.assertEqual(kind.__module__, "emberline")
        self.assertEqual(emberline.Error.__bases__, (Exception,))

    def test_settings(self):
        with self.assert_error(emberline.UsageError, "did you mean 'spp'"):
            emberline.Settings(sppp=1)
        with self.assert_error(emberline.UsageError, "spp", "'0'"):
            emberline.render(self.box, spp=0)
        with self.assert_error(emberline.UsageError, "did you mean 'sobol'"):
            emberline.render(self.box, sampler="sobel")
        with self.assert_error(TypeError, "spp: expected", "NoneType"):
            emberline.Settings(spp=None)
        with self.assert_error(TypeError, "spp: expected", "object"):
            emberline.Settings()["spp"] = object()
        with self.assert_error(TypeError, "look-at: expected an array with one dimension"):
            emberline.Settings(look_at=np.eye(3))
        with self.assert_error(ValueError, "env: has a null character"):
            emberline.Settings(env="a.hdr\0.png")
        with self.assert_error(emberline.UsageError, "env: it takes effect when the scene is loaded"):
            emberline.render(self.box, env="studio.hdr")
        with self.assert_error(emberline.UsageError, "threads: -1"):
            emberline.render(self.box, threads=-1)
        with self.assert_error(emberline.UsageError, "working_space: it takes effect when the scene is loaded"):
            emberline.render(self.box, working_space="acescg")
        with self.assert_error(emberline.UsageError, "cryptomatte: this setting needs the names of the nodes"):
            emberline.render(self.box, cryptomatte="object")
        with self.assert_error(emberline.UsageError, "light_groups requires integrator path or direct: normal does not compute lighting"):
            emberline.render(self.box, light_groups=True, integrator="normal")
        with self.assert_error(TypeError, "resume and keep_checkpoint require checkpoint"):
            emberline.render(self.box, resume=True)
        with self.assert_error(emberline.UsageError, "checkpoint_interval: nan"):
            emberline.render(self.box, checkpoint="a", checkpoint_interval=float("nan"))
        with self.assert_error(emberline.UsageError, "merge needs at least one checkpoint"):
            emberline.merge([])
        with self.assert_error(emberline.InputError, str(BOX)):
            emberline.merge([BOX])
        with self.assert_error(emberline.InputError, "/no/file"):
            emberline.stored_frame("/no/file")
        with self.assert_error(emberline.UsageError, "did you mean"):
            emberline.Settings.help("drivr")
        with self.assert_error(TypeError, "progress: expected a function"):
            emberline.render(self.box, progress=3)

    def test_files(self):
        folder = self.folder()
        with self.assert_error(emberline.InputError, "/no/scene.glb"):
            emberline.Scene("/no/scene.glb")
        with self.assert_error(ValueError, "null character"):
            emberline.Scene(str(BOX) + "\0")
        with self.assertRaises(TypeError):
            emberline.Scene(7)
        broken = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 9}}]}],
        }
        (folder / "broken.gltf").write_text(json.dumps(broken))
        with self.assert_error(emberline.InputError, "broken.gltf#/meshes/0/primitives/0"):
            emberline.Scene(folder / "broken.gltf")
        with self.assert_error(emberline.InputError, "raise memory_limit"):
            emberline.Scene(BOX, memory_limit=1000)
        with self.assert_error(emberline.InputError, "README.md"):
            emberline.read(ROOT / "README.md")
        with self.assert_error(emberline.InputError):
            emberline.read(folder / "\udcff.exr")
        picture = emberline.render(self.box)
        with self.assert_error(emberline.UsageError, ".png, .jpg, .jpeg"):
            emberline.write(folder / "a.gif", picture)
        with self.assert_error(emberline.RenderError, "does not exist"):
            emberline.write(folder / "no" / "a.exr", picture)
        self.assertEqual(os.listdir(folder), ["broken.gltf"])

    def test_edits(self):
        for edits, kind in (({"lights": 3}, emberline.InputError), ("{", emberline.InputError),
                            ({"lihgts": []}, emberline.InputError), (3, TypeError), ({1j: 2}, TypeError),
                            ({"environment": {"strength": float("nan")}}, ValueError),
                            ({"lights": [object()]}, TypeError), ({"emberline_edits": 99}, emberline.InputError)):
            with self.subTest(edits), self.assert_error(kind):
                self.box.edit(edits)

        sky = np.ones((4, 8, 3), "float32")
        for wrong, kind, text in ((sky[0], ValueError, "environment"), (sky.astype("float64"), TypeError, "float64")):
            with self.assert_error(kind, text):
                self.box.edit({}, environment=wrong)
        for value in (np.nan, np.inf, -1):
            sky[1, 2, 0] = value
            with self.assert_error(emberline.UsageError, "at column 2 of row 1"):
                self.box.edit({}, environment=sky)
        file = {"environment": {"file": str(ROOT / "scenes/dusk.hdr")}}
        with self.assert_error(emberline.UsageError, "a file in the edits"):
            self.box.edit(file, environment=np.ones((4, 8, 3), "float32"))

    def test_arrays(self):
        rgb = emberline.render(self.box)["RGB"]
        black = np.zeros_like(rgb)
        # Arrays may have any order, strides and byte order, and a smaller float type.
        spread = np.zeros((32, 48, 6), "float32")
        spread[::2, ::2, ::2] = rgb
        for same in (np.asfortranarray(rgb), rgb[::-1].copy()[::-1], spread[::2, ::2, ::2], rgb.astype(">f4")):
            self.assertEqual(emberline.compare(same, rgb.copy()).different_pixels, 0)
        self.assertGreater(emberline.compare(rgb[::-1], rgb).different_pixels, 0)
        half = rgb.astype("float16")
        self.assertEqual(emberline.compare(half, half.astype("float32")).mse, 0)
        for wrong, kind, text in (
            (rgb.astype("float64"), TypeError, "float64"),
            ((255 * rgb).astype("uint8"), TypeError, "uint8"),
            (rgb.astype("complex64"), TypeError, "complex64"),
            (rgb.astype(object), TypeError, "object"),
            (rgb > 0, TypeError, "bool"),
            (rgb.tolist(), TypeError, "not list"),
            (None, TypeError, "NoneType"),
            (rgb[..., 0], ValueError, "(16, 24)"),
            (rgb[..., :2], ValueError, "(16, 24, 2)"),
            (np.moveaxis(rgb, -1, 0), ValueError, "(3, 16, 24)"),
            (rgb[None], ValueError, "(1, 16, 24, 3)"),
            (rgb[:0], ValueError, "(0, 24, 3)"),
            (np.float32(1), TypeError, "image"),
            (rgb[:8], ValueError, "different sizes"),
        ):
            with self.subTest(text):
                for call in (emberline.compare, emberline.flip):
                    with self.assert_error(kind, text):
                        call(wrong, black)
        huge = np.broadcast_to(np.float32(0), (2**31, 1, 3))
        with self.assert_error(ValueError, "too large"):
            emberline.compare(huge, huge)
        with self.assert_error(emberline.UsageError, "exposure"):
            emberline.compare(rgb, rgb, exposure=float("inf"))
        rgb[0, 0, 0] = np.nan
        self.assertEqual(emberline.compare(rgb, black).non_finite, 1)
        self.assertEqual(emberline.flip(rgb, black)[0, 0], 0)

    def test_written_arrays(self):
        folder = self.folder()
        rgb = emberline.render(self.box)["RGB"]
        out = folder / "a.exr"
        for wrong, kind, text, more in (
            (rgb.astype("float64"), TypeError, "float64", {}),
            (rgb[..., :2], ValueError, "expected 2 names", {}),
            (rgb, ValueError, "expected 3 names", {"channels": ["a"]}),
            (rgb, emberline.UsageError, "two channels called a", {"channels": ["a", "a", "b"]}),
            (rgb, emberline.UsageError, "with an invalid name", {"channels": ["a", "", "b"]}),
            (rgb, ValueError, "expected 3 names", {"channels": itertools.repeat("a")}),
            (rgb, TypeError, "channels: expected a string, not int", {"channels": [1, 2, 3]}),
            (rgb, TypeError, "channels: expected a string, not bytes", {"channels": [b"a", b"b", b"c"]}),
            (rgb, ValueError, "is not valid Unicode", {"channels": ["a\udcff", "b", "c"]}),
            (rgb, emberline.UsageError, "invalid name", {"channels": ["a" * 256, "b", "c"]}),
            (rgb[0, 0], ValueError, "(3,)", {}),
            (rgb[:0], ValueError, "(0, 24, 3)", {}),
            ("picture", TypeError, "not str", {}),
            ((rgb > 0).astype("uint8"), TypeError, "uint8", {"exposure": 1}),
            ((rgb > 0).astype("uint8"), emberline.UsageError, ".png", {}),
            (np.zeros((2, 2, 2), "uint8"), emberline.UsageError, "1, 3 or 4", {}),
            (np.zeros((0, 2, 3), "uint8"), emberline.UsageError, "no pixels", {}),
            (np.zeros(3, "uint8"), ValueError, "(3,)", {}),
            (emberline.render(self.box), TypeError, "its own names", {"channels": ["a"]}),
        ):
            with self.subTest(text), self.assert_error(kind, text):
                emberline.write(out, wrong, **more)
        many = np.zeros((1, 1, 4097), "float32")
        with self.assert_error(emberline.UsageError, "more than 4096 channels"):
            emberline.write(out, many, channels=map(str, range(4097)))
        with self.assert_error(emberline.UsageError, "no channel R"):
            emberline.write(folder / "a.png", rgb[..., 0])
        self.assertEqual(os.listdir(folder), [])

    def test_messages_go_to_logging(self):
        logger = logging.getLogger("emberline")
        with self.assertLogs(logger, "WARNING") as caught:
            emberline.Scene(ROOT / "scenes/checker_plane.glb", **SMALL)
        self.assertIn("the scene has no light", caught.output[0])


if __name__ == "__main__":
    unittest.main()
