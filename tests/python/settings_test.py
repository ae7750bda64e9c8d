"""Uses every setting once in the command, the library and Python. All channels must have the same bits."""
import json
import re
import struct
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np

import emberline
from support import BOX, SCENES, Test

EMBERLINE, LIBRARY_FRAME = sys.argv.pop(1), sys.argv.pop(1)
BLADE, ROOM = SCENES / "moving_blade.glb", SCENES / "window_room.glb"
SMALL = {"size": "16x16", "spp": "4", "max-depth": "3"}
ADAPTIVE = {"driver": "adaptive"}
VIEW = {"look-from": "0,1,6", "look-at": "0,1,0"}

# Each setting has a text other than its default, the other settings that it needs, and a scene.
CASES = {
    "edits": ("edits.json", {}, BOX),
    "variant": ("dark", {}, "variants.glb"),
    "aov": ("variance,albedo,N,Z,P,UV,direct,indirect,emission,id,stop", {}, BOX),
    "cryptomatte": ("object,material,asset", {}, BOX),
    "cryptomatte-levels": ("3", {"cryptomatte": "object"}, BOX),
    "catcher": ("floor", {"transparent": "yes"}, BOX),
    "catcher-plane": ("bottom", {"transparent": "yes"}, BOX),
    "holdout": ("tall block", {"transparent": "yes"}, BOX),
    "half": ("N,RGBA", {"aov": "N"}, BOX),
    "exr-compression": ("piz", {}, BOX),
    "exr-parts": ("layers", {"aov": "N"}, BOX),
    "part": ("2/3", {"bucket-size": "4"}, BOX),
    "plan": ("frame.plan", {**ADAPTIVE, "spp": "16"}, BOX),
    "sample-range": ("1-3", {"spp": None}, BOX),
    "turntable": ("2/8", {}, BOX),
    "turntable-center": ("look-at", {**VIEW, "turntable": "2/8"}, BOX),
    "light-groups": ("yes", {}, BLADE),
    "denoise": ("yes", {"light-groups": "yes", "spp": "16"}, BLADE),
    "driver": ("bisection", {}, BOX),
    "sampler": ("hierarchical", {}, BOX),
    "streams": ("2", {"aov": "variance"}, BOX),
    "spp": ("6", {}, BOX),
    "noise-threshold": ("0.05", {**ADAPTIVE, "spp": None}, BOX),
    "min-spp": ("8", {**ADAPTIVE, "noise-threshold": "0.1", "spp": None}, BOX),
    "max-spp": ("32", {**ADAPTIVE, "noise-threshold": "0.02", "spp": None}, BOX),
    "estimator": ("dammertz", {**ADAPTIVE, "noise-threshold": "0.1", "spp": None}, BOX),
    "allocation": ("mse", {**ADAPTIVE, "spp": "24"}, BOX),
    "judge": ("RGB,A:0.02", {**ADAPTIVE, "noise-threshold": "0.1", "spp": None}, BOX),
    "unbiased": ("yes", {**ADAPTIVE, "spp": "16"}, BOX),
    "time-limit": ("1000", {}, BOX),
    "time-budget": ("0.001", {"spp": None, "size": "640x360"}, BOX),  # too short: one sample per pixel
    "integrator": ("normal", {}, BOX),
    "max-depth": ("5", {}, BOX),
    "light-samples": ("3", {}, BOX),
    "clamp-indirect": ("0.5", {"aov": "clamped"}, BOX),
    "filter": ("gaussian", {}, BOX),
    "filter-radius": ("2", {}, BOX),
    "seed": ("7", {}, BOX),
    "static-noise": ("yes", {"frame": "4"}, BLADE),
    "bucket-size": ("5", {}, BOX),
    "bucket-order": ("spiral", {"bucket-size": "4"}, BOX),
    "bisection-axis": ("rows", {"driver": "bisection"}, BOX),
    "reconstruction": ("linear", {"driver": "bisection"}, BOX),
    "size": ("20x12", {}, BOX),
    "crop": ("3,2,12,9", {}, BOX),
    "camera": ("camera", {}, BOX),
    "look-from": (VIEW["look-from"], {"look-at": VIEW["look-at"]}, BOX),
    "look-at": (VIEW["look-at"], {"look-from": VIEW["look-from"]}, BOX),
    "fov-y": ("70", {}, BOX),
    "f-stop": ("0.1", {"focus-distance": "2"}, BOX),
    "focus-distance": ("3", {"f-stop": "0.1"}, BOX),
    "panorama": ("yes", {}, BOX),
    "env": (str(SCENES / "dusk.hdr"), VIEW, BOX),
    "sun": ("30,40", VIEW, BOX),
    "env-strength": ("2.5", {**VIEW, "sun": "30,40"}, BOX),
    "env-rotation": ("60", {**VIEW, "sun": "30,40"}, BOX),
    "env-sampling": ("light", {}, ROOM),
    "guiding": ("on", {}, BOX),
    "transparent": ("yes", VIEW, BOX),
    "working-space": ("acescg", {"light-groups": "yes"}, BOX),
    "backfaces": ("show", VIEW, BOX),
    "animation": ("blades", {}, BLADE),
    "time": ("0.3", {}, BLADE),
    "frame": ("4", {"aov": "velocity"}, BLADE),
    "fps": ("30", {"frame": "4"}, BLADE),
    "shutter": ("0,0.5", {"frame": "4"}, BLADE),
    "lenient": ("yes", {}, BOX),
    "isa": ("", {}, BOX),  # settings_of() replaces the empty text by the first name in the help
    "resource-root": (str(SCENES), {}, BOX),
}

def with_variants(scene, to):
    """Writes a copy of the box to the file `to`, with a variant that gives its meshes another material."""
    data = scene.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    gltf, rest = json.loads(data[20:20 + length]), data[20 + length:]
    gltf["extensionsUsed"].append("KHR_materials_variants")
    gltf["extensions"] = {"KHR_materials_variants": {"variants": [{"name": "bright"}, {"name": "dark"}]}}
    for mesh in gltf["meshes"]:
        mesh["primitives"][0]["extensions"] = {
            "KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}
        }
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 20 + len(text) + len(rest))
    to.write_bytes(head + struct.pack("<II", len(text), 0x4E4F534A) + text + rest)


def bits(picture):
    """Returns the bits of each channel by its name, because the order of channels depends on the file."""
    return {name: np.ascontiguousarray(picture[name]).view(np.uint32) for name in picture.channels}


class EverySetting(Test):
    @classmethod
    def setUpClass(cls):
        cls.names = re.findall(r"^([a-z-]+)(?: \S+)?: ", emberline.Settings.help(), re.M)

    def setUp(self):
        self.work = self.folder()
        with_variants(BOX, self.work / "variants.glb")
        light = {"kind": "material", "name": "light", "intensity": 0.5}
        (self.work / "edits.json").write_text(json.dumps({"emberline_edits": 1, "lights": [light]}))

    def settings_of(self, name):
        value, companions, scene = CASES[name]
        if name == "isa":
            value = re.search(r"^  (\S+):", emberline.Settings.help("isa"), re.M)[1]
        if name in ("edits", "plan"):
            value = str(self.work / value)
        settings = {**SMALL, **companions, name: value}
        settings = {n: v for n, v in settings.items() if v is not None}
        if name == "plan":
            planned = [f"--{n}={v}" for n, v in settings.items() if n != "plan"]
            subprocess.run([EMBERLINE, "plan", scene, "-o", value, "--quiet", *planned], check=True)
        return settings, self.work / scene

    def command(self, settings, scene):
        """Returns the channels that the command writes. If the settings render a part, merges that part alone."""
        file = self.work / "command.exr"
        options = [f"--{n}" if v == "yes" else f"--{n}={v}" for n, v in settings.items()]
        run = [EMBERLINE, "render", scene, "-o", file, "--quiet", *options]
        subprocess.run(run, check=True)
        parts = list(self.work.glob("*.checkpoint"))
        if parts:
            merge = [EMBERLINE, "merge", *parts, "-o", file, "--allow-holes", "--quiet"]
            subprocess.run(merge, check=True)
        return bits(emberline.read(file))

    def library(self, settings, scene):
        file = self.work / "library.exr"
        subprocess.run([LIBRARY_FRAME, scene, file, *(f"{n}={v}" for n, v in settings.items())], check=True)
        return bits(emberline.read(file))

    def python(self, settings, scene):
        """Returns the channels of the written file and of the picture, because half and working_space affect only the
        file."""
        file = self.work / "python.exr"
        arguments = {n.replace("-", "_"): v for n, v in settings.items()}
        opened = emberline.Scene(scene, **arguments)
        picture = emberline.render(opened)
        emberline.write(file, picture)
        return bits(emberline.read(file)), bits(picture)

    def assert_equal(self, a, b, what):
        self.assertEqual(set(a), set(b), what)
        for channel in a:
            np.testing.assert_array_equal(a[channel], b[channel], f"{what}: {channel}")

    def test_each_has_a_case(self):
        self.assertEqual(set(self.names), set(CASES))
        self.assertGreater(len(self.names), 50)
        for name in CASES:
            settings, _ = self.settings_of(name)
            set_text = emberline.Settings(**{name.replace("-", "_"): settings[name]})[name]
            self.assertNotEqual(set_text, emberline.Settings()[name], name)


def add_case(name):
    def test(self):
        settings, scene = self.settings_of(name)
        command = self.command(settings, scene)
        self.assert_equal(command, self.library(settings, scene), "the library")
        file, arrays = self.python(settings, scene)
        self.assert_equal(command, file, "Python")
        if name not in ("half", "working-space"):
            self.assert_equal(command, arrays, "Python's arrays")

    setattr(EverySetting, "test_" + name.replace("-", "_"), test)


for _name in CASES:
    add_case(_name)

if __name__ == "__main__":
    unittest.main()
