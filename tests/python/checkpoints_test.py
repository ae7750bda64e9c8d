"""Tests checkpoints, parts, heatmaps and studies. The command and Python must accept each other's files."""
import csv
import subprocess
import sys
import unittest

import numpy as np

import emberline
from support import BOX, Test

EMBERLINE = sys.argv.pop(1)
FRAME = {"size": (48, 32), "spp": 16, "max_depth": 3, "bucket_size": 8}
OPTIONS = ["--size=48x32", "--spp=16", "--max-depth=3", "--bucket-size=8", "--quiet"]


def command(*arguments):
    subprocess.run([EMBERLINE, *map(str, arguments)], check=True)


class Checkpoints(Test):
    @classmethod
    def setUpClass(cls):
        cls.box = emberline.Scene(BOX, **FRAME)

    def setUp(self):
        self.work = self.folder()
        self.file = self.work / "frame.checkpoint"

    def assert_same(self, picture, other):
        np.testing.assert_array_equal(picture["RGBA"], other["RGBA"])
        np.testing.assert_array_equal(picture["samples"], other["samples"])

    def test_the_command_goes_on_with_ours(self):
        for driver in ("bucket", "bisection", "adaptive"):
            with self.subTest(driver):
                whole = emberline.render(self.box, driver=driver)
                watch = lambda now: now.samples < whole.samples / 2
                part = emberline.render(self.box, driver=driver, checkpoint=self.file, progress=watch)
                self.assertFalse(part.complete)
                self.assertTrue(self.file.exists())
                out = self.work / "out.exr"
                command("render", BOX, "-o", out, "--checkpoint", self.file, "--resume", "--driver", driver, *OPTIONS)
                self.assert_same(emberline.read(out), whole)
                self.assertFalse(self.file.exists())

    def test_we_go_on_with_the_commands(self):
        out = self.work / "out.exr"
        command("render", BOX, "-o", out, "--resumable", "--driver", "bisection", *OPTIONS)
        checkpoint = self.work / "out.exr.checkpoint"
        stored = emberline.stored_frame(checkpoint)
        self.assertEqual((stored.scene, stored.settings["spp"], stored.mattes), (str(BOX), "16", {}))
        seen = []
        again = emberline.render(self.box, driver="bisection", checkpoint=checkpoint, resume=True,
                                 keep_checkpoint=True, progress=lambda now: seen.append(now.samples))
        self.assert_same(again, emberline.read(out))
        with self.assert_error(emberline.InputError, "seed: 0 (now 4)"):
            emberline.render(self.box, driver="bisection", checkpoint=checkpoint, resume=True, seed=4)
        more = emberline.extend(checkpoint, spp=32)
        self.assert_same(more, emberline.render(self.box, driver="bisection", spp=32))
        self.assertEqual(emberline.stored_frame(checkpoint).settings["spp"], "32")
        with self.assert_error(emberline.UsageError, "spp: ", "already has 32"):
            emberline.extend(checkpoint, self.box, spp=16)

    def test_parts_of_both_are_merged_by_both(self):
        whole = emberline.render(self.box)
        ours, theirs = self.work / "ours", self.work / "theirs"
        emberline.render(self.box, part="1/2", checkpoint=ours)
        command("render", BOX, "-o", self.work / "a.exr", "--part", "2/2", "--checkpoint", theirs, *OPTIONS)
        out = self.work / "out.exr"
        command("merge", ours, theirs, "-o", out, "--quiet")
        self.assert_same(emberline.read(out), whole)
        merged = emberline.merge([ours, theirs], parts=True)
        self.assert_same(merged, whole)
        self.assertEqual(set(np.unique(merged["part"])), {1, 2})
        with self.assert_error(emberline.InputError, "the parts lack", "allow_holes"):
            emberline.merge([ours])

    def test_heatmaps_are_the_commands(self):
        exr = self.work / "a.exr"
        picture = emberline.render(self.box, driver="adaptive", aov="variance,stop")
        emberline.write(exr, picture)
        self.assertIn("error", emberline.heatmap_kinds())
        for of, look, options in (
            ("samples", {}, []),
            ("samples", {"colors": "viridis", "log": True}, ["--colors=viridis", "--log"]),
            ("samples", {"range": (0, 40), "plain": True}, ["--range=0,40", "--plain"]),
            # These have no legend, because legends name settings, which are called --spp in the command and spp in
            # Python.
            ("error", {"colors": "viridis", "log": True, "plain": True}, ["--colors=viridis", "--log", "--plain"]),
            ("stop", {"plain": True}, ["--plain"]),
        ):
            with self.subTest(of=of, **look):
                theirs, ours = self.work / "theirs.png", self.work / "ours.png"
                command("heatmap", exr, "--of", of, "-o", theirs, *options)
                drawn = emberline.heatmap(picture, of, **look)
                self.assertEqual((drawn.dtype, drawn.shape[2]), (np.uint8, 3))
                self.assertTrue(drawn.shape[0] >= 32 and drawn.shape[1] >= 48, "the legend adds to it")
                emberline.write(ours, drawn)
                self.assertEqual(ours.read_bytes(), theirs.read_bytes())
        np.testing.assert_array_equal(emberline.heatmap_values(picture), picture["samples"])
        with self.assert_error(emberline.InputError, "render it with aov time"):
            emberline.heatmap_values(picture, "time")

    def test_a_study_has_the_rows_of_its_file(self):
        folder = self.work / "study"
        table = emberline.study(BOX, folder, drivers="bucket,bisection", spp=[1, 2], seeds=2, size=(16, 16),
                                max_depth=2)
        self.assertTrue(table.complete)
        self.assertIn("bisection", table.text)
        with open(folder / "study.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(table.rows))
        self.assertEqual(len(rows), 2 * 2 * 2)
        for row, said in zip(table.rows, rows):
            self.assertEqual((row["method"], row["seed"]), (said["method"], int(said["seed"])))
            for name in ("budget", "mean_samples", "mse", "relmse", "flip", "signed_bias", "wall_s"):
                self.assertEqual(row[name], float(said[name]), name)
        again = emberline.study(BOX, folder, drivers=["bucket", "bisection"], spp=[1, 2], seeds=2, size=(16, 16),
                                max_depth=2)
        self.assertEqual(again.rows, table.rows)  # these rows were read from the folder
        with self.assert_error(emberline.UsageError, "working_space"):
            emberline.study(BOX, folder, working_space="acescg")
        for name, value in (("light_groups", True), ("noise_threshold", 0.1), ("aov", "N"), ("edits", "a.json")):
            with self.assert_error(emberline.UsageError, name + ": study does not accept this setting"):
                emberline.study(BOX, folder, **{name: value})
        with self.assert_error(emberline.UsageError, "reference_spp", "whole number"):
            emberline.study(BOX, folder, reference_spp="many")
        with self.assert_error(emberline.UsageError, "reference_spp, cache", "reference names a picture"):
            emberline.study(BOX, folder, reference="a.exr", reference_spp=8)

    def test_a_scene_whose_files_have_changed_is_not_saved(self):
        file = self.work / "box.glb"
        file.write_bytes(BOX.read_bytes())
        scene = emberline.Scene(file, **FRAME)
        emberline.render(scene, checkpoint=self.file)
        file.write_bytes(BOX.read_bytes())
        with self.assert_error(emberline.InputError, "box.glb: its files have changed since they were read; start again"):
            emberline.render(scene, checkpoint=self.file)
        self.assertFalse(self.file.exists())
        self.assert_same(emberline.render(scene), emberline.render(self.box))


if __name__ == "__main__":
    unittest.main()
