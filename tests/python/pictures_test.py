"""Tests the contents of pictures and the lifetime of their memory, and that they match the command's pictures."""
import copy
import gc
import json
import subprocess
import sys
import unittest

import numpy as np

import emberline
from support import BOX, SCENES, SMALL, Test

EMBERLINE = sys.argv.pop(1)
LIGHT = {"kind": "material", "name": "light"}


class Pictures(Test):
    def test_layers_are_arrays(self):
        picture = emberline.render(self.box, aov=["variance", "N", "Z"], crop=(4, 5, 20, 15))
        self.assertEqual(picture.layers, ["RGB", "A", "samples", "variance", "N", "Z"])
        self.assertEqual((picture.width, picture.height, picture.x, picture.y), (16, 10, 4, 5))
        self.assertEqual((picture.frame_width, picture.frame_height), (24, 16))
        for name, shape in {"RGB": (10, 16, 3), "RGBA": (10, 16, 4), "N": (10, 16, 3), "Z": (10, 16),
                            "samples": (10, 16), "N.X": (10, 16), "error": (10, 16, 3)}.items():
            with self.subTest(name):
                self.assertEqual(picture[name].shape, shape)
                self.assertEqual(picture[name].dtype, np.float32)
        self.assertEqual(picture.pixels.shape, (10, 16, len(picture.channels)))
        np.testing.assert_array_equal(picture.pixels[..., :3], picture["RGB"])
        np.testing.assert_array_equal(picture["alpha"], picture["A"])
        np.testing.assert_array_equal(picture["samples"], 4)
        lengths = np.linalg.norm(picture["N"], axis=-1)
        self.assertLessEqual(lengths.max(), 1.0001)
        self.assertAlmostEqual(float(np.median(lengths)), 1, places=5)
        np.testing.assert_array_equal(picture["error"], np.sqrt(picture["variance"]))
        self.assertTrue(picture.complete)
        self.assertEqual(picture.samples, 4 * 160)
        self.assertGreater(picture.rays, picture.samples)
        self.assertIn("N", picture)
        self.assertNotIn("albedo", picture)
        with self.assertRaisesRegex(KeyError, "the picture has no such channel or layer; it has RGB, A"):
            picture["albedo"]
        with self.assertRaisesRegex(KeyError, "aov"):
            emberline.render(self.box)["error"]

    def test_arrays_outlive_scene_and_picture(self):
        scene = emberline.Scene(BOX, **SMALL)
        picture = emberline.render(scene)
        rgb, error = picture["RGB"], emberline.compare(picture, picture)
        kept = rgb.copy()
        del scene, picture
        gc.collect()
        noise = [np.random.rand(16, 24, 5).astype("float32") for _ in range(200)]
        np.testing.assert_array_equal(rgb, kept)
        self.assertEqual(error.mse, 0)
        del noise
        rgb *= 2  # the caller owns the array
        np.testing.assert_array_equal(rgb, 2 * kept)

    def test_bits_are_the_commands(self):
        folder = self.folder()
        common = ["--size", "24x16", "--spp", "4", "--max-depth", "3", "--aov", "N", "--quiet"]
        subprocess.run([EMBERLINE, "render", BOX, "-o", folder / "a.exr", *common], check=True)
        command = emberline.read(folder / "a.exr")
        for more in ({}, {"threads": 1}, {"driver": "bisection"}):
            picture = emberline.render(self.box, aov="N", **more)
            for layer in ("RGB", "A", "N", "samples"):
                np.testing.assert_array_equal(picture[layer], command[layer])

    def command(self, scene, layers, *options):
        """Renders the scene with the command, with the settings of SMALL. Returns these layers of the picture."""
        file = self.folder() / "a.exr"
        common = ["--size", "24x16", "--spp", "4", "--max-depth", "3", "--quiet"]
        subprocess.run([EMBERLINE, "render", scene, "-o", file, *common, *options], check=True)
        picture = emberline.read(file)
        return {layer: picture[layer] for layer in layers}

    def test_poses(self):
        blade = SCENES / "moving_blade.glb"
        layers = ("RGB", "Z", "velocity")
        scene = emberline.Scene(blade, animated=True, aov="Z,velocity", time=0.3, **SMALL)
        edit = {"lights": [{"kind": "material", "name": "window", "on": False}]}
        seen = []
        for when in ({"time": 0.02}, {"time": 0.3, "shutter": (0, 0.5)}, {"time": 0.02}):
            scene.pose(**when)
            options = [f"--{name}={','.join(map(str, v)) if isinstance(v, tuple) else v}" for name, v in when.items()]
            command = self.command(blade, layers, "--aov", "Z,velocity", *options)
            picture = emberline.render(scene)
            for layer in layers:
                np.testing.assert_array_equal(picture[layer], command[layer])
            scene.edit(edit)
            dark = emberline.render(scene)["RGB"]
            scene.pose(**when)  # must keep the edits
            np.testing.assert_array_equal(emberline.render(scene)["RGB"], dark)
            scene.edit({})
            seen.append(picture["RGB"])
        self.assertFalse(np.array_equal(seen[0], seen[1]))
        for wrong in ({"time": "soon"}, {"animation": "none"}, {"time": 0.1, "frame": 2}):
            with self.assert_error(emberline.UsageError, *list(wrong)[:1]):
                scene.pose(**wrong)
        np.testing.assert_array_equal(emberline.render(scene)["RGB"], seen[2])
        for still in (emberline.Scene(blade, **SMALL), emberline.Scene(BOX, animated=True, **SMALL)):
            with self.assert_error(emberline.UsageError, "pose"):
                still.pose(time=1)

    def test_catchers_and_holdouts(self):
        settings = {"catcher": "floor", "holdout": "tall block", "transparent": True}
        layers = ("RGB", "A", "shadow")
        command = self.command(BOX, layers, "--catcher", "floor", "--holdout", "tall block", "--transparent")
        scene = emberline.Scene(BOX, **SMALL, **settings)
        picture = emberline.render(scene)
        for layer in layers:
            np.testing.assert_array_equal(picture[layer], command[layer])
        self.assertEqual(picture["A"].min(), 0)
        with self.assert_error(emberline.UsageError, "holdout", "loaded with another value"):
            emberline.render(scene, holdout="short block")

    def test_edits(self):
        scene = emberline.Scene(BOX, **SMALL)
        whole = emberline.render(scene)["RGB"]
        for edit in ({"lights": [{**LIGHT, "intensity": np.float32(0.5)}]},
                     '{"emberline_edits": 1, "lights": [{"kind": "material", "name": "light", "intensity": 0.5}]}'):
            scene.edit(edit)
            np.testing.assert_array_equal(2 * emberline.render(scene)["RGB"], whole)
        with self.assert_error(emberline.InputError, "the edits#/lights/0", "'white'"):
            scene.edit({"lights": [{**LIGHT, "name": "lihgt"}]})
        np.testing.assert_array_equal(2 * emberline.render(scene)["RGB"], whole)
        scene.edit({})
        np.testing.assert_array_equal(emberline.render(scene)["RGB"], whole)

    def test_what_a_scene_has(self):
        scene = emberline.Scene(BOX, env=SCENES / "dusk.hdr", env_strength=0.3, **SMALL)
        self.assertEqual(scene.materials, ["white", "red", "green", "light"])
        self.assertEqual(scene.lights, ["light", "environment"])
        self.assertEqual(scene.cameras, ["camera"])
        floor = next(node for node in scene.nodes if node["name"] == "floor")
        self.assertEqual((floor["mesh"], floor["camera"], floor["in_scene"]), (True, False, True))
        self.assertEqual([node["index"] for node in scene.nodes], list(range(len(scene.nodes))))
        blade = emberline.Scene(SCENES / "moving_blade.glb", **SMALL)
        self.assertEqual([animation["name"] for animation in blade.animations], ["blades"])
        self.assertGreater(blade.animations[0]["duration_s"], 0)
        self.assertFalse(any("animation" in text for text in blade.ignored))

    def test_editable_values_change_nothing(self):
        scene = emberline.Scene(BOX, env=SCENES / "dusk.hdr", env_strength=0.3, **SMALL)
        whole = emberline.render(scene)["RGB"]
        edits = scene.editable
        self.assertEqual([light.get("name", light["kind"]) for light in edits["lights"]], scene.lights)
        self.assertEqual([material["name"] for material in edits["materials"]], scene.materials)
        scene.edit(edits)
        np.testing.assert_array_equal(emberline.render(scene)["RGB"], whole)
        edits["environment"]["strength"] = 3
        scene.edit(edits)
        self.assertGreater(emberline.render(scene)["RGB"].mean(), whole.mean())
        self.assertNotEqual(scene.editable, edits)  # `editable` has the values of the file

    def test_an_environment_from_an_array(self):
        sky = SCENES / "dusk.hdr"
        settings = {**SMALL, "look_from": (0, 1, 6), "look_at": (0, 1, 0)}
        file = emberline.render(emberline.Scene(BOX, env=sky, **settings))["RGB"]
        scene = emberline.Scene(BOX, **settings)
        bare = emberline.render(scene)["RGB"]
        texels = emberline.read(sky)["RGB"]
        scene.edit({}, environment=texels)
        np.testing.assert_array_equal(emberline.render(scene)["RGB"], file)
        scene.edit({"environment": {"strength": 2}}, environment=emberline.read(sky))
        self.assertGreater(emberline.render(scene)["RGB"].mean(), file.mean())
        scene.edit({}, environment=np.asfortranarray(texels)[::1])
        texels[:] = 0  # must have no effect, because the scene has a copy
        np.testing.assert_array_equal(emberline.render(scene)["RGB"], file)
        scene.edit({})
        np.testing.assert_array_equal(emberline.render(scene)["RGB"], bare)

    def test_error_estimates(self):
        seen = []
        picture = emberline.render(self.box, driver="adaptive", spp=64, progress=lambda now: seen.append(now))
        self.assertIsNone(emberline.render(self.box).error_estimate)
        self.assertIsNotNone(seen[-1].error_estimate)
        reference = emberline.render(self.box, spp=1024, seed=7)
        display = [np.interp(p["RGB"], [0, 1], [0, 1]) ** (1 / 2.2) for p in (picture, reference)]
        true = np.sqrt(np.mean((display[0] - display[1]) ** 2))
        self.assertLess(abs(np.log(picture.error_estimate / true)), np.log(2))

    def test_settings(self):
        settings = emberline.Settings(spp=np.int64(7), noise_threshold=0.25, size=[8, 6], transparent=True, aov="N")
        self.assertEqual(settings["spp"], "7")
        self.assertEqual(settings["noise-threshold"], settings["noise_threshold"])
        self.assertEqual(float(settings["noise-threshold"]), 0.25)
        self.assertEqual(settings["size"], "8x6")
        self.assertEqual(settings["transparent"], "yes")
        self.assertIsNone(settings["min_spp"])
        self.assertIn("spp='7'", repr(settings))
        other, copied = emberline.Settings(settings, spp=8), copy.deepcopy(settings)
        settings["spp"] = 9
        self.assertEqual((other["spp"], copied["spp"], dict(settings)["spp"]), ("8", "7", "9"))
        self.assertIn("spp", settings)
        self.assertNotIn("min-spp", settings)
        self.assertIn("adaptive", emberline.Settings.help("driver"))
        self.assertIn("noise-threshold", emberline.Settings.help())
        point = emberline.Settings(look_from=np.array([1.5, 2, -3], "float32"))
        self.assertEqual([float(x) for x in point["look_from"].split(",")], [1.5, 2, -3])
        scene = emberline.Scene(BOX, size=(8, 8))
        self.assertEqual(scene.settings["size"], "8x8")
        self.assertEqual(emberline.render(scene, emberline.Settings(size=(9, 7), spp=1)).width, 9)


class Files(Test):
    def test_written_and_read(self):
        folder = self.folder()
        picture = emberline.render(self.box, aov=["N", "albedo"], crop=(2, 3, 20, 15))
        emberline.write(folder / "a.exr", picture)
        again = emberline.read(folder / "a.exr")
        for layer in picture.layers:
            np.testing.assert_array_equal(again[layer], picture[layer])
        self.assertEqual((again.x, again.y, again.frame_width, again.frame_height), (2, 3, 24, 16))
        stopped = emberline.render(self.box, driver="bisection", spp=4096, progress=lambda now: now.samples < 2000)
        self.assertFalse(stopped.complete)
        emberline.write(folder / "b.exr", stopped)
        self.assertFalse(emberline.read(folder / "b.exr").complete)
        three = np.arange(2 * 3 * 3, dtype="float16").reshape(2, 3, 3)
        emberline.write(folder / "c.exr", three)
        np.testing.assert_array_equal(emberline.read(folder / "c.exr")["RGB"], three)
        emberline.write(folder / "d.exr", three, channels=["a", "b", "c"])
        np.testing.assert_array_equal(emberline.read(folder / "d.exr")["b"], three[..., 1])
        emberline.write(folder / "e.exr", three[..., 0])
        np.testing.assert_array_equal(emberline.read(folder / "e.exr")["Y"], three[..., 0])

    def test_colours_of_a_file_are_rec_709(self):
        folder = self.folder()
        common = ["--size", "24x16", "--spp", "4", "--max-depth", "3", "--aov", "albedo", "--quiet"]
        subprocess.run([EMBERLINE, "render", BOX, "-o", folder / "a.exr", *common], check=True)
        subprocess.run(
            [EMBERLINE, "render", BOX, "-o", folder / "b.exr", "-o", folder / "b.png", "--working-space", "acescg", *common],
            check=True,
        )
        plain, read = emberline.read(folder / "a.exr"), emberline.read(folder / "b.exr")
        np.testing.assert_allclose(read["albedo"], plain["albedo"], atol=1e-5)
        self.assertLess(emberline.compare(read, plain).rmse, 0.02)
        emberline.write(folder / "c.png", read)
        difference = emberline.read(folder / "b.png")["RGB"] - emberline.read(folder / "c.png")["RGB"]
        self.assertLess(np.abs(difference).max(), 0.01)

    def test_png_is_the_commands(self):
        folder = self.folder()
        common = ["--size", "24x16", "--spp", "4", "--max-depth", "3", "--quiet"]
        subprocess.run([EMBERLINE, "render", BOX, "-o", folder / "a.png", *common], check=True)
        emberline.write(folder / "b.png", emberline.render(self.box))
        np.testing.assert_array_equal(*(emberline.read(folder / name)["RGB"] for name in ("a.png", "b.png")))
        levels = np.zeros((4, 5, 3), "uint8")
        levels[1, 2] = (0, 128, 255)
        emberline.write(folder / "c.png", levels[:, ::-1])
        read = emberline.read(folder / "c.png")["RGB"]
        np.testing.assert_allclose(read[1, 2], (0, ((128 / 255 + 0.055) / 1.055) ** 2.4, 1), atol=1e-4)

    def test_compare_is_the_commands(self):
        folder = self.folder()
        pictures = [emberline.render(self.box, seed=seed) for seed in (0, 1)]
        for name, picture in zip("ab", pictures):
            emberline.write(folder / f"{name}.exr", picture)
        result = subprocess.run(
            [EMBERLINE, "compare", folder / "a.exr", folder / "b.exr", "--json"], check=True, capture_output=True
        )
        said = json.loads(result.stdout)
        for name, value in emberline.compare(*pictures).as_dict().items():
            self.assertEqual(value, said[name], name)
        flip = emberline.flip(*pictures)
        self.assertEqual(flip.shape, (16, 24))
        self.assertAlmostEqual(float(flip.mean(dtype="float64")), said["flip"], places=6)

    def test_compare_knows_the_working_space(self):
        """Compares a picture in ACEScg with a picture in Rec. 709, and checks that the command gives the same
        result."""
        folder = self.folder()
        scenes = [emberline.Scene(BOX, size=(24, 16), spp=4, working_space=s) for s in ("acescg", "rec709")]
        pictures = [emberline.render(scene) for scene in scenes]
        files = [folder / "a.exr", folder / "b.exr"]
        for file, picture in zip(files, pictures):
            emberline.write(file, picture)
        result = subprocess.run([EMBERLINE, "compare", *files, "--json"], check=True, capture_output=True)
        said = json.loads(result.stdout)
        for name, value in emberline.compare(*pictures).as_dict().items():
            self.assertEqual(value, said[name], name)
        self.assertEqual(emberline.flip(pictures[0], emberline.read(files[0])).max(), 0)
        self.assertLess(said["rmse"], emberline.compare(pictures[0]["RGB"].copy(), pictures[1]).rmse)


if __name__ == "__main__":
    unittest.main()
