#!/usr/bin/env python3
"""Measures the cost of motion in a whole frame: a scene at rest, with all non-emissive meshes moving, and deforming.

    motion_cost.py [--emberline BINARY] [--scene scenes/teapot.glb] [--rounds 5] [--size 320x180] [--spp 16]

The versions are rendered alternately on one thread, and their processor times compared within each round. A mesh
moves 1 cm sideways, or sideways while turning by 5 degrees; to deform, it grows by 4 mm along its normals. Everything
stays in the picture at all times. Prints a table (tests/bench/results) of medians with extremes in brackets.
"""

import argparse
import json
import pathlib
import statistics
import struct
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
TURN = (0.0, 0.0436194, 0.0, 0.999048)  # 5 degrees about y, as a quaternion


def read_glb(path):
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), bytearray(data[28 + length :])


def write_glb(path, document, binary):
    document["buffers"][0]["byteLength"] = len(binary)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(binary), len(text), b"JSON")
    path.write_bytes(head + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def product(a, b):
    (ax, ay, az, aw), (bx, by, bz, bw) = a, b
    return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz]


class Version:
    def __init__(self, scene):
        self.document, self.binary = read_glb(scene)
        self.document["animations"] = [{"name": "motion", "samplers": [], "channels": []}]
        self.seconds = self.floats([0.0, 1.0], "SCALAR", min=[0.0], max=[1.0])

    def floats(self, values, kind, **more):
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[kind]
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": 4 * len(values)}
        self.document["bufferViews"].append(view)
        self.binary += struct.pack(f"<{len(values)}f", *values)
        self.document["accessors"].append({"bufferView": len(self.document["bufferViews"]) - 1, "componentType": 5126,
                                           "type": kind, "count": len(values) // width, **more})
        return len(self.document["accessors"]) - 1

    def animate(self, node, path, kind, values):
        motion = self.document["animations"][0]
        motion["channels"].append({"sampler": len(motion["samplers"]), "target": {"node": node, "path": path}})
        motion["samplers"].append({"input": self.seconds, "output": self.floats(values, kind)})

    def surfaces(self):
        """Yields the index and the node for each node whose mesh is not emissive."""
        for i, node in enumerate(self.document["nodes"]):
            primitives = self.document["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []
            materials = [self.document["materials"][p["material"]] for p in primitives]
            if materials and not any("emissiveFactor" in m for m in materials):
                yield i, node

    def move(self, turn):
        for i, node in self.surfaces():
            at = node.get("translation", [0, 0, 0])
            self.animate(i, "translation", "VEC3", [*at, at[0] + 0.01, *at[1:]])
            if turn:
                rest = node.get("rotation", [0, 0, 0, 1])
                self.animate(i, "rotation", "VEC4", [*rest, *product(TURN, rest)])

    def deform(self):
        for i, node in self.surfaces():
            mesh = self.document["meshes"][node["mesh"]]
            for primitive in mesh["primitives"]:
                if "targets" in primitive:
                    continue
                normals = self.document["accessors"][primitive["attributes"]["NORMAL"]]
                self.document["accessors"].append({**normals, "min": [-1, -1, -1], "max": [1, 1, 1]})
                primitive["targets"] = [{"POSITION": len(self.document["accessors"]) - 1}]
            mesh["weights"] = [0.0]
            self.animate(i, "weights", "SCALAR", [0.0, 0.004 / node.get("scale", [1])[0]])


def render(options, scene, folder):
    report = folder / "report.json"
    command = [options.emberline, "render", scene, "-o", folder / "frame.exr", "--report", report,
               "--size", options.size, "--spp", options.spp, "--time", 0, "--fps", 1, "--shutter", "0,1",
               "--threads", 1, "--quiet"]
    subprocess.run([str(word) for word in command], check=True)
    return json.loads(report.read_text())


def spread(values):
    low, middle, high = (f"{v:.2f}" for v in (min(values), statistics.median(values), max(values)))
    return f"{middle} ({low}–{high})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--emberline", type=pathlib.Path, default=ROOT / "build/release/bin/emberline")
    parser.add_argument("--scene", type=pathlib.Path, default=ROOT / "scenes/teapot.glb")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--spp", type=int, default=16)
    options = parser.parse_args()
    changes = {"at rest": lambda version: None, "moves": lambda version: version.move(turn=False),
               "moves and turns": lambda version: version.move(turn=True), "vertices move": Version.deform}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes, reports = {}, {}
        for number, (what, change) in enumerate(changes.items()):
            version = Version(options.scene)
            change(version)
            scenes[what] = folder / f"{number}.glb"
            reports[what] = []
            write_glb(scenes[what], version.document, version.binary)
        for _ in range(options.rounds):
            for what, scene in scenes.items():
                reports[what].append(render(options, scene, folder))
    print("| | million rays per processor second | time per ray, relative to rest | BVH, geometry, MiB |")
    print("| --- " * 4 + "|")
    paces = {what: [r["rays"]["total"] / r["time"]["render_cpu_s"] / 1e6 for r in rounds]
             for what, rounds in reports.items()}
    for what, rounds in reports.items():
        ratios = [rest / pace for rest, pace in zip(paces["at rest"], paces[what])]
        memory = (f"{rounds[0]['memory'][key] / 2**20:.1f}" for key in ("bvh_bytes", "geometry_bytes"))
        print(f"| {what} | {spread(paces[what])} | {spread(ratios)} | {', '.join(memory)} |")


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(f"motion_cost.py: {error}")
