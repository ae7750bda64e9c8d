"""Tests every row of the channel table, alone and with all other rows, with files, checkpoints, parts and crops.

The table comes from `emberline info --channels --json`, so a new row is tested automatically.
"""
import json
import subprocess
import sys
import unittest

import numpy as np

import emberline
from support import SCENES, Test

EMBERLINE = sys.argv.pop(1)
SCENE = SCENES / "moving_blade.glb"
FRAME = {"size": (24, 16), "spp": 16, "max_depth": 3, "streams": 2, "frame": 4, "bucket_size": 8,
         "clamp_indirect": 0.05}
# The settings that a row needs in addition to its name in `aov`, or instead of it.
NEEDS = {
    "shadow": {"catcher": "desk"},
    "rays": {"catcher": "desk"},  # a catcher casts rays
    "light": {"light_groups": True},
    "Crypto": {"cryptomatte": "object,material", "cryptomatte_levels": 4},
    "denoised": {"denoise": True},
}
LOSSLESS, LOSSY = ("none", "zips", "zip", "piz"), ("dwaa", "dwab")
ROWS = json.loads(subprocess.check_output([EMBERLINE, "info", "--channels", "--json"]))


def settings_of(rows):
    settings = dict(FRAME)
    for row in rows:
        settings.update(NEEDS.get(row["name"], {}))
    aovs = [row["name"] for row in rows if row["setting"] == "aov"]
    return {**settings, "aov": ",".join(aovs)} if aovs else settings


def options_of(settings):
    def text(value):
        if value is True:
            return "yes"
        return "x".join(map(str, value)) if isinstance(value, tuple) else str(value)

    names = {name: name.replace("_", "-") for name in settings}
    return [f"--{names[n]}" if v is True else f"--{names[n]}={text(v)}" for n, v in settings.items()]


def channels_of(row, picture):
    """Returns the channels of a picture that belong to a row. If the scene names the channels, they are found by their
    prefix."""
    if row["name"] == "denoised":
        return [name for name in picture.channels if name.startswith("denoised.")]
    if row["channels"]:
        return [name for name in row["channels"] if name in picture]
    return [name for name in picture.channels if name.startswith(row["name"])]


def depends_on_clock(channel):
    return channel == "time"


class Channels(Test):
    @classmethod
    def setUpClass(cls):
        cls.all = settings_of(ROWS)
        cls.scene = emberline.Scene(SCENE, **cls.all)
        cls.picture = emberline.render(cls.scene)

    def setUp(self):
        self.work = self.folder()

    def assert_same(self, picture, channels, expected, where=np.s_[:]):
        for name in channels:
            if depends_on_clock(name):
                self.assertGreater(picture[name].sum(), 0.0)
                continue
            with self.subTest(name):
                a, b = picture[name].view(np.uint32), expected(name)[where].view(np.uint32)
                np.testing.assert_array_equal(a, b)

    def all_values(self, name):
        return np.ascontiguousarray(self.picture[name])

    def render_file(self, **more):
        file = self.work / "picture.exr"
        options = options_of({**self.all, **more})
        subprocess.run([EMBERLINE, "render", SCENE, "-o", file, "--quiet", *options], check=True)
        return emberline.read(file)

    def test_the_table_is_complete(self):
        names = [row["name"] for row in ROWS]
        self.assertEqual(len(names), len(set(names)))
        listed = [channel for row in ROWS for channel in channels_of(row, self.picture)]
        self.assertEqual(sorted(set(listed)), sorted(listed), "a channel of two rows")
        # The picture has channels that are in no row: Cryptomatte's counts of dropped ids, and the sums of shares
        # (half1.shared.*, half2.shared.*) that a file has instead of the shares.
        others = set(self.picture.channels) - set(listed)
        self.assertTrue(all(name.startswith(("dropped.", "half")) for name in others), others)
        for row in ROWS:
            self.assertTrue(channels_of(row, self.picture), row["name"])
        denoised = {name for name in self.picture.channels if name.startswith("denoised.")}
        for row in ROWS:
            clean = {f"denoised.{name}" for name in channels_of(row, self.picture)} & denoised
            self.assertEqual(row["denoised"], bool(clean), row["name"])

    def test_something_is_in_each(self):
        # The scene shows no flat mirror (tests/numerics/specular_velocity_test.cpp has some).
        nothing = {"non_finite", "part", "specular_velocity"}
        # These channels need another scene, because this one has neither glass nor a sky, and no visible lamp.
        elsewhere = {"emission", "transmission", "environment"}
        other = emberline.Scene(SCENES / "glass_metal.glb", panorama=True, sun="30,40")
        others = emberline.render(other, size=(32, 24), spp=4, aov=",".join(elsewhere))
        for row in ROWS:
            picture = others if row["name"] in elsewhere else self.picture
            values = [picture[name] for name in channels_of(row, picture)]
            with self.subTest(row["name"]):
                finite = [v[np.isfinite(v)] for v in values]
                self.assertEqual(any(np.any(v != 0) for v in finite), row["name"] not in nothing)

    def test_files_without_loss(self):
        # One compression is enough for files with several parts, because it does not depend on the number of parts.
        for compression, parts in (*((name, "one") for name in LOSSLESS), ("zip", "layers")):
            with self.subTest(f"{compression}, {parts}"):
                picture = self.render_file(exr_compression=compression, exr_parts=parts)
                self.assertEqual(set(picture.channels), set(self.picture.channels))
                self.assert_same(picture, picture.channels, self.all_values)

    def test_lossy_files_keep_what_is_no_colour(self):
        lossy = {name for row in ROWS if row["lossy"] for name in channels_of(row, self.picture)}
        for compression in LOSSY:
            with self.subTest(compression):
                picture = self.render_file(exr_compression=compression, exr_parts="layers")
                self.assert_same(picture, set(picture.channels) - lossy, self.all_values)
                for name in lossy - {"A"}:
                    peak = np.abs(self.all_values(name)).max()
                    np.testing.assert_allclose(picture[name], self.all_values(name), atol=0.1 * peak + 1e-3)

    def test_half_floats(self):
        layers = [row["name"] for row in ROWS if row["half"]]
        halves = {name for row in ROWS if row["half"] for name in channels_of(row, self.picture)}
        picture = self.render_file(half=",".join(layers))

        def as_half(name):
            if name not in halves:
                return self.all_values(name)
            return np.clip(self.all_values(name), -65504, 65504).astype(np.float16).astype(np.float32)

        self.assert_same(picture, picture.channels, as_half)
        for row in ROWS:
            if not row["half"]:
                with self.assert_error(emberline.UsageError, "half: "):
                    emberline.Settings(half=row["name"])

    def test_resumed(self):
        for driver in ("bucket", "bisection"):
            file = self.work / driver
            stop = lambda now: now.samples < 24 * 16 * 8
            begun = emberline.render(self.scene, driver=driver, checkpoint=file, progress=stop)
            self.assertFalse(begun.complete)
            picture = emberline.render(self.scene, driver=driver, checkpoint=file, resume=True)
            self.assert_same(picture, picture.channels, self.all_values)

    def test_parts_are_merged(self):
        files = [self.work / str(part) for part in (1, 2)]
        for part, file in enumerate(files, 1):
            emberline.render(self.scene, part=f"{part}/2", checkpoint=file)
        merged = emberline.merge(files, parts=True)
        self.assertEqual(set(np.unique(merged["part"])), {1.0, 2.0})
        self.assert_same(merged, set(merged.channels) - {"part"}, self.all_values)

    def test_samples_are_merged(self):
        """Merges two sample ranges. Merging adds sums, so means are rounded in another way than in a single run, and
        full lists of mattes drop other ids."""
        files = [self.work / name for name in ("0-8", "8-16")]
        settings = {name: value for name, value in self.all.items() if name != "spp"}
        scene = emberline.Scene(SCENE, **settings)
        for file in files:
            emberline.render(scene, sample_range=file.name, checkpoint=file)
        merged = emberline.merge(files)
        for name in merged.channels:
            if not depends_on_clock(name) and not name.startswith(("Crypto", "dropped", "part")):
                with self.subTest(name):
                    np.testing.assert_allclose(merged[name], self.all_values(name), rtol=1e-4, atol=1e-5)

    def test_crops(self):
        picture = emberline.render(self.scene, crop="5,3,17,12")
        # These channels differ at the border of a crop, because the denoiser and the sums of neighbours' samples have
        # less data there.
        channels = [n for n in picture.channels if not n.startswith("denoised.") and ".shared" not in n]
        self.assert_same(picture, channels, self.all_values, np.s_[3:12, 5:17])


def add_row(row):
    def test(self):
        picture = emberline.render(emberline.Scene(SCENE, **settings_of([row])))
        channels = channels_of(row, picture)
        self.assertTrue(channels)
        self.assert_same(picture, channels, self.all_values)

    setattr(Channels, f"test_{row['name']}_alone", test)


for _row in ROWS:
    add_row(_row)

if __name__ == "__main__":
    unittest.main()
