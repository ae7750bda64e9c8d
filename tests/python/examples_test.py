"""Runs the examples at a small size."""
import re
import subprocess
import sys
import unittest

import numpy as np

import emberline
from support import EXAMPLES, SCENES, Test

SIZE = ["--size", "32", "24"]


class Examples(Test):
    def run_example(self, name, *arguments):
        self.ran.add(name)
        command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True, cwd=self.folder()).stdout

    ran = set()

    def test_error_against_samples(self):
        out = self.run_example(
            "error_against_samples.py", SCENES / "cornell_box.glb", *SIZE, "--spp", 4, 16, "--seeds", 2
        )
        rows = re.findall(r"^(\w+, \w+) +([0-9.e+-]+) +([0-9.e+-]+) +(-[0-9.]+)$", out, re.M)
        self.assertEqual(len(rows), 4, out)
        for _, few, many, slope in rows:
            self.assertLess(float(many), float(few))
            self.assertLess(float(slope), -0.5)

    def test_relight(self):
        picture = self.folder() / "relit.png"
        out = self.run_example(
            "relight.py", SCENES / "teapot.glb", "--lamps", "window", "fill", "--weights", 0.3, 2, *SIZE,
            "--spp", 16, "-o", picture,
        )
        bias = float(re.search(r"signed bias ([+-][0-9.]+) %", out)[1])
        self.assertLess(abs(bias), 3, out)
        self.assertEqual(emberline.read(picture)["RGB"].shape, (24, 32, 3))

    def test_where_samples_went(self):
        picture = self.folder() / "samples.png"
        out = self.run_example("where_samples_went.py", SCENES / "teapot.glb", *SIZE, "--spp", 16, "-o", picture)
        expected, found = (
            np.array([float(x) for x in re.search(name + r": +(.*)$", out, re.M)[1].split()])
            for name in ("expected RMS error", "RMS error found")
        )
        self.assertLess(abs(np.log(expected.mean() / found.mean())), np.log(3), out)
        colours = emberline.read(picture)["RGB"]
        self.assertEqual(colours.shape, (24, 32, 3))
        self.assertGreater(np.ptp(colours), 0.5)

    def test_layers(self):
        shot = self.folder() / "shot"
        out = self.run_example(
            "layers.py", SCENES / "teapot.glb", "--lamp", "window", "--weight", 0, "--object", "teapot", *SIZE,
            "--spp", 16, "-o", shot,
        )
        self.assertIn("lights: fill, rim, window", out)
        covered = float(re.search(r"teapot covers ([0-9.]+) %", out)[1])
        self.assertTrue(2 < covered < 60, out)
        mask = emberline.read(f"{shot}_mask.png")["RGB"]
        self.assertTrue(mask.min() == 0 and mask.max() > 0.5)
        lit = emberline.read(f"{shot}.exr")["RGB"].mean()
        self.assertLess(emberline.read(f"{shot}_relit.png")["RGB"].mean(), lit)
        self.assertGreater(emberline.read(f"{shot}_samples.png").height, 24)  # the legend adds to the height

    def test_resume_and_merge(self):
        out = self.run_example(
            "resume_and_merge.py", SCENES / "cornell_box.glb", "--folder", self.folder(), "--size", 48, 32, "--spp", 16
        )
        self.assertIn("extended to 32 samples a pixel", out)
        self.assertIn("the same bits: True True True", out)

    def test_speed_against_error(self):
        folder = self.folder() / "study"
        out = self.run_example(
            "speed_against_error.py", SCENES / "cornell_box.glb", "--folder", folder, "--budgets", 1, 4, "--seeds", 2,
            *SIZE,
        )
        rows = re.findall(r"^(\w\S*) +([14]) +([0-9.e+-]+) +[0-9.e+-]+$", out, re.M)
        self.assertEqual([(method, budget) for method, budget, _ in rows][:2], [("bucket", "1"), ("bucket", "4")], out)
        self.assertLess(float(rows[1][2]), float(rows[0][2]))
        self.assertTrue((folder / "study.csv").exists())

    @classmethod
    def tearDownClass(cls):
        assert cls.ran == {path.name for path in EXAMPLES.glob("*.py")}, "each is run"


if __name__ == "__main__":
    unittest.main()
