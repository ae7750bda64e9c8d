"""Compares the load and build time of the later frames of a range with that of the first frame.

    pose_cost.py EMBERLINE [SCENE ...] [--side 700]

Uses a hill of 2 x SIDE^2 triangles under a box, and the given scenes with all their animations.
"""
import argparse
import array
import json
import math
import pathlib
import struct
import subprocess
import tempfile


class Glb:
    def __init__(self):
        self.root = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [], "nodes": [],
                     "scenes": [{"nodes": []}], "animations": []}
        self.bin = bytearray()

    def accessor(self, kind, code, values, width):
        data = array.array(code, values)
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bin), "byteLength": len(data) * 4})
        self.bin += data.tobytes()
        entry = {"bufferView": len(self.root["bufferViews"]) - 1, "componentType": 5126 if code == "f" else 5125,
                 "count": len(data) // width, "type": kind}
        if kind == "VEC3":
            entry["min"], entry["max"] = ([f(data[c::3]) for c in range(3)] for f in (min, max))
        self.root["accessors"].append(entry)
        return len(self.root["accessors"]) - 1

    def node(self, **members):
        self.root["nodes"].append(members)
        self.root["scenes"][0]["nodes"].append(len(self.root["nodes"]) - 1)
        return len(self.root["nodes"]) - 1

    def hill(self, side, height):
        positions, indices = [], []
        for y in range(side + 1):
            for x in range(side + 1):
                positions += [x / side - .5, height * math.sin(9 * x / side) * math.cos(7 * y / side), y / side - .5]
        for y in range(side):
            for x in range(side):
                a = y * (side + 1) + x
                indices += [a, a + side + 1, a + 1, a + 1, a + side + 1, a + side + 2]
        primitive = {"attributes": {"POSITION": self.accessor("VEC3", "f", positions, 3)},
                     "indices": self.accessor("SCALAR", "I", indices, 1)}
        self.root["meshes"].append({"primitives": [primitive]})
        return len(self.root["meshes"]) - 1

    def move(self, name, target, kind, values, width):
        sampler = {"input": self.accessor("SCALAR", "f", [0, 2], 1), "output": self.accessor(kind, "f", values, width)}
        self.root["animations"].append({"name": name, "samplers": [sampler],
                                        "channels": [{"sampler": 0, "target": target}]})

    def write(self, path):
        self.root["buffers"] = [{"byteLength": len(self.bin)}]
        text = json.dumps(self.root).encode()
        text += b" " * (-len(text) % 4)
        path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(self.bin), len(text), 0x4E4F534A)
                         + text + struct.pack("<II", len(self.bin), 0x004E4942) + self.bin)


def made_scene(side, path):
    glb = Glb()
    hill = glb.node(mesh=glb.hill(side, .05))
    box = glb.node(mesh=glb.hill(4, .1), scale=[.2, .2, .2], translation=[0, .2, 0])
    glb.root["cameras"] = [{"type": "perspective", "perspective": {"yfov": .6, "znear": .1}}]
    camera = glb.node(camera=0, translation=[0, .4, 1.6])
    glb.root["extensionsUsed"] = ["KHR_lights_punctual", "KHR_animation_pointer"]
    glb.root["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3}]}}
    glb.node(translation=[.5, 1, .5], extensions={"KHR_lights_punctual": {"light": 0}})
    path_of_light = "/extensions/KHR_lights_punctual/lights/0/intensity"
    glb.move("camera", {"node": camera, "path": "translation"}, "VEC3", [0, .4, 1.6, .3, .4, 1.5], 3)
    glb.move("light", {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": path_of_light}}},
             "SCALAR", [3, 9], 1)
    glb.move("box", {"node": box, "path": "translation"}, "VEC3", [0, .2, 0, .3, .3, 0], 3)
    glb.move("hill", {"node": hill, "path": "translation"}, "VEC3", [0, 0, 0, .1, 0, 0], 3)
    glb.write(path)


def costs(emberline, scene, animation, folder):
    subprocess.run([emberline, "render", str(scene), "--animation", animation, "--frames", "1-5", "--size", "16x16",
                    "--spp", "1", "-q", "-o", f"{folder}/a.#.exr", "--report", f"{folder}/a.#.json"], check=True)
    times = [json.loads((folder / f"a.{n}.json").read_text())["time"] for n in range(1, 6)]
    both = [1e3 * (t["load_s"] + t["build_s"]) for t in times]
    return both[0], sorted(both[1:])[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("emberline")
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--side", type=int, default=700)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        made = folder / "hill.glb"
        made_scene(options.side, made)
        rows = [(made, animation) for animation in ("camera", "light", "box", "hill")]
        rows += [(scene, "all") for scene in options.scenes]
        print("| scene | animation | frame 1 ms | later ms | share |\n| --- | --- | --- | --- | --- |")
        for scene, animation in rows:
            first, later = costs(options.emberline, scene, animation, folder)
            print(f"| {scene.stem} | {animation} | {first:.1f} | {later:.2f} | {100 * later / first:.2f} % |")


if __name__ == "__main__":
    main()
