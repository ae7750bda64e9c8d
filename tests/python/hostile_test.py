"""What is wrong is said in one line, by the right type; nothing is taken for what it is not."""
import json
import logging
import os
import unittest

import numpy as np

import emberline
from support import BOX, ROOT, SMALL, Test


class WrongInput(Test):
    def test_one_hierarchy(self):
        for kind in (emberline.UsageError, emberline.InputError, emberline.RenderError):
            self.assertEqual(kind.__bases__, (emberline.Error,))
            self.assertEqual(kind.__module__, "emberline")
        self.assertEqual(emberline.Error.__bases__, (Exception,))

    def test_settings(self):
        with self.says(emberline.UsageError, "did you mean 'spp'"):
            emberline.Settings(sppp=1)
        with self.says(emberline.UsageError, "--spp", "'0'"):
            emberline.render(self.box, spp=0)
        with self.says(emberline.UsageError, "did you mean 'sobol'"):
            emberline.render(self.box, sampler="sobel")
        with self.says(TypeError, "spp: a NoneType"):
            emberline.Settings(spp=None)
        with self.says(TypeError, "spp: a object"):
            emberline.Settings()["spp"] = object()
        with self.says(TypeError, "look-at: an array of one dimension"):
            emberline.Settings(look_at=np.eye(3))
        with self.says(ValueError, "env: has a null character"):
            emberline.Settings(env="a.hdr\0.png")
        with self.says(emberline.UsageError, "env: is decided when the scene is loaded"):
            emberline.render(self.box, env="studio.hdr")
        with self.says(emberline.UsageError, "threads: -1"):
            emberline.render(self.box, threads=-1)
        with self.says(emberline.UsageError, "the command alone"):
            emberline.render(self.box, denoise=True)
        with self.says(emberline.UsageError, "working-space: the command alone"):
            emberline.Scene(BOX, working_space="acescg")
        with self.says(emberline.UsageError, "cryptomatte: the command alone"):
            emberline.Scene(BOX, cryptomatte="object")
        with self.says(emberline.UsageError, "did you mean"):
            emberline.Settings.help("drivr")
        with self.says(TypeError, "progress: not callable"):
            emberline.render(self.box, progress=3)

    def test_files(self):
        folder = self.folder()
        with self.says(emberline.InputError, "/no/scene.glb"):
            emberline.Scene("/no/scene.glb")
        with self.says(ValueError, "null character"):
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
        with self.says(emberline.InputError, "broken.gltf#/meshes/0/primitives/0"):
            emberline.Scene(folder / "broken.gltf")
        with self.says(emberline.InputError, "--memory-limit"):
            emberline.Scene(BOX, memory_limit=1000)
        with self.says(emberline.InputError, "README.md"):
            emberline.read(ROOT / "README.md")
        with self.says(emberline.InputError):
            emberline.read(folder / "\udcff.exr")
        picture = emberline.render(self.box)
        with self.says(emberline.UsageError, ".png, .jpg, .jpeg"):
            emberline.write(folder / "a.gif", picture)
        with self.says(emberline.RenderError, "does not exist"):
            emberline.write(folder / "no" / "a.exr", picture)
        self.assertEqual(os.listdir(folder), ["broken.gltf"])

    def test_edits(self):
        for edits, kind in (({"lights": 3}, emberline.InputError), ("{", emberline.InputError),
                            ({"lihgts": []}, emberline.InputError), (3, TypeError), ({1j: 2}, TypeError),
                            ({"environment": {"strength": float("nan")}}, ValueError),
                            ({"lights": [object()]}, TypeError), ({"emberline_edits": 99}, emberline.InputError)):
            with self.subTest(edits), self.says(kind):
                self.box.edit(edits)

        sky = np.ones((4, 8, 3), "float32")
        for wrong, kind, text in ((sky[0], ValueError, "environment"), (sky.astype("float64"), TypeError, "float64")):
            with self.says(kind, text):
                self.box.edit({}, environment=wrong)
        for value in (np.nan, np.inf, -1):
            sky[1, 2, 0] = value
            with self.says(emberline.UsageError, "at column 2 of row 1"):
                self.box.edit({}, environment=sky)
        file = {"environment": {"file": str(ROOT / "scenes/dusk.hdr")}}
        with self.says(emberline.UsageError, "name a file as well"):
            self.box.edit(file, environment=np.ones((4, 8, 3), "float32"))

    def test_arrays(self):
        rgb = emberline.render(self.box)["RGB"]
        black = np.zeros_like(rgb)
        # Order, strides, byte order and a smaller float are no loss.
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
            (rgb.tolist(), TypeError, "a list"),
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
                    with self.says(kind, text):
                        call(wrong, black)
        huge = np.broadcast_to(np.float32(0), (2**31, 1, 3))
        with self.says(ValueError, "too large"):
            emberline.compare(huge, huge)
        with self.says(emberline.UsageError, "exposure"):
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
            (rgb[..., :2], ValueError, "names of 2", {}),
            (rgb, ValueError, "names of 3", {"channels": ["a"]}),
            (rgb, emberline.UsageError, "two channels a", {"channels": ["a", "a", "b"]}),
            (rgb, emberline.UsageError, "without a proper name", {"channels": ["a", "", "b"]}),
            (rgb[0, 0], ValueError, "(3,)", {}),
            (rgb[:0], ValueError, "(0, 24, 3)", {}),
            ("picture", TypeError, "a str", {}),
            ((rgb > 0).astype("uint8"), TypeError, "uint8", {"exposure": 1}),
            ((rgb > 0).astype("uint8"), emberline.UsageError, ".png", {}),
            (np.zeros((2, 2, 2), "uint8"), emberline.UsageError, "1, 3 or 4", {}),
            (np.zeros((0, 2, 3), "uint8"), emberline.UsageError, "no pixels", {}),
            (np.zeros(3, "uint8"), ValueError, "(3,)", {}),
            (emberline.render(self.box), TypeError, "names of its own", {"channels": ["a"]}),
        ):
            with self.subTest(text), self.says(kind, text):
                emberline.write(out, wrong, **more)
        with self.says(emberline.UsageError, "no channel R"):
            emberline.write(folder / "a.png", rgb[..., 0])
        self.assertEqual(os.listdir(folder), [])

    def test_messages_go_to_logging(self):
        logger = logging.getLogger("emberline")
        with self.assertLogs(logger, "WARNING") as caught:
            emberline.Scene(ROOT / "scenes/checker_plane.glb", **SMALL)
        self.assertIn("the scene has no light", caught.output[0])


if __name__ == "__main__":
    unittest.main()
