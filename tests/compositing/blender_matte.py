#!/usr/bin/env python3
"""Checks that Blender's Cryptomatte node picks the right mattes from our files.

    tests/compositing/blender_matte.py [--emberline build/release/bin/emberline] [--blender blender] [--keep DIR]

The test renders scenes/teapot.glb with mattes, into a file with a single part and into a file with one part per layer.
Blender's compositor picks some names of each kind. Each of its mattes must be the sum of the coverages that our file
has for the id of the name. If Blender or oiiotool is not installed, the exit code is 77, which ctest counts as skipped.
The test takes about half a minute.
"""
import argparse
import json
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SIZE = (160, 90)
PICKS = {"CryptoObject": ["teapot", "lemon 2", "table"], "CryptoMaterial": ["china", "lemon"], "CryptoAsset": ["wall"]}

# This script runs in Blender. Its arguments after "--" are FILE, OUT, and the picks and the size as JSON. It writes
# each matte as an EXR with one float channel.
IN_BLENDER = """
import bpy, json, sys
file, out, picks, size = sys.argv[-4], sys.argv[-3], json.loads(sys.argv[-2]), json.loads(sys.argv[-1])
scene = bpy.context.scene
scene.use_nodes = True
scene.render.resolution_x, scene.render.resolution_y = size
scene.render.resolution_percentage = 100
tree = scene.node_tree
tree.nodes.clear()
image = bpy.data.images.load(file)
layers = set()
writer = tree.nodes.new("CompositorNodeOutputFile")
writer.base_path = out
writer.format.file_format = "OPEN_EXR"
writer.format.color_depth = "32"
writer.format.exr_codec = "NONE"
writer.file_slots.clear()
for layer, names in picks.items():
    for index, name in enumerate(names):
        node = tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source = "IMAGE"
        node.image = image
        layers |= {item.identifier for item in type(node).bl_rna.properties["layer_name"].enum_items}
        node.layer_name = layer
        node.matte_id = name
        slot = writer.file_slots.new(f"{layer}_{index}_")
        tree.links.new(node.outputs["Matte"], writer.inputs[-1])
tree.links.new(node.outputs["Matte"], tree.nodes.new("CompositorNodeComposite").inputs["Image"])
bpy.ops.render.render(scene=scene.name)
"""


def planes_of(path):
    """Reads the channels of an uncompressed float EXR with scan lines, without a library."""
    data = path.read_bytes()
    at, header = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<i", data, at)
        header[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    names, listed = [], header[b"channels"]
    while len(listed) > 1:
        name, listed = listed.split(b"\0", 1)
        assert struct.unpack_from("<i", listed)[0] == 2, "not a float"
        names.append(name.decode())
        listed = listed[16:]
    x0, y0, x1, y1 = struct.unpack("<4i", header[b"dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    assert header[b"compression"] == b"\0"
    planes = {name: [] for name in names}
    at += 1 + 8 * height
    for _ in range(height):
        at += 8
        for name in names:
            planes[name] += struct.unpack_from(f"<{width}f", data, at)
            at += 4 * width
    return planes


def read_planes(path, to):
    """Copies each layer of our file to a simpler file for planes_of(), and returns the channels of all layers."""
    info = subprocess.run(["oiiotool", "--info", str(path)], check=True, capture_output=True, text=True).stdout
    layers = [f"{layer}0{rank}" for layer in PICKS for rank in range(3)]
    planes = {}
    for layer in layers:
        part = ["--subimage", layer] if "subimages" in info else []
        command = ["oiiotool", str(path), *part, "--ch", ",".join(f"{layer}.{c}" for c in "RGBA"), "--scanline"]
        command += ["--compression", "none", "-d", "float", "-o", str(to)]
        subprocess.run(command, check=True, capture_output=True)
        planes |= planes_of(to)
    return planes


def manifests(path):
    info = subprocess.run(["oiiotool", "--info", "-v", str(path)], check=True, capture_output=True, text=True).stdout
    values = {}
    for line in info.splitlines():
        line = line.strip()
        if line.startswith("cryptomatte/"):
            key, _, value = line.partition(": ")
            values[key] = value.strip()[1:-1]
    return {
        value: json.loads(values[key[: -len("name")] + "manifest"]) for key, value in values.items() if key.endswith("/name")
    }


def matte(planes, layer, id_hex):
    id_hex = struct.unpack("<f", bytes.fromhex(id_hex)[::-1])[0]
    sums = None
    for rank in range(3):
        for of_id, of_coverage in (("R", "G"), ("B", "A")):
            ids, coverages = planes[f"{layer}0{rank}.{of_id}"], planes[f"{layer}0{rank}.{of_coverage}"]
            sums = sums or [0.0] * len(ids)
            sums = [s + (c if i == id_hex else 0.0) for s, i, c in zip(sums, ids, coverages)]
    return sums


def check(command, blender, folder, more):
    frame = folder / "frame.exr"
    subprocess.run(
        [command, "render", ROOT / "scenes/teapot.glb", "-o", frame, "--size", "x".join(map(str, SIZE)), "--spp", "16"]
        + ["--cryptomatte", "object,material,asset", *more],
        check=True,
    )
    script = folder / "in_blender.py"
    script.write_text(IN_BLENDER)
    run = subprocess.run(
        [blender, "-b", "--factory-startup", "--python-exit-code", "1", "-P", script, "--"]
        + [frame, folder, json.dumps(PICKS), json.dumps(SIZE)],
        capture_output=True,
        text=True,
    )
    if run.returncode:
        sys.exit(f"Blender failed:\n{run.stdout[-2000:]}{run.stderr[-2000:]}")
    named = manifests(frame)
    planes = read_planes(frame, folder / "plain.exr")
    for layer, picks in PICKS.items():
        for index, name in enumerate(picks):
            expected = matte(planes, layer, named[layer][name])
            shown = planes_of(next(folder.glob(f"{layer}_{index}_*.exr")))["R"]
            worst = max(abs(a - b) for a, b in zip(expected, shown))
            covered = sum(expected)
            print(f"{layer} {name}: {covered:.1f} pixels, largest difference {worst:.2g}")
            if worst > 1e-5 or covered < 3:
                sys.exit(f"{layer} {name}: Blender's matte is not the file's")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--emberline", default=ROOT / "build/release/bin/emberline")
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--keep", type=Path, help="leave the files in this folder")
    options = parser.parse_args()
    if not shutil.which(options.blender) or not shutil.which("oiiotool"):
        print("no blender, or no oiiotool: nothing is tested")
        return 77
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.keep or Path(scratch)
        folder.mkdir(exist_ok=True)
        for more in ([], ["--exr-parts", "layers", "--exr-compression", "dwaa"]):
            print(" ".join(more) or "as it comes")
            check(options.emberline, options.blender, folder, more)
    return 0


if __name__ == "__main__":
    sys.exit(main())
