#!/usr/bin/env python3
"""many_emitters.py EMBERLINE [COUNT...]: measures the setup of COUNT small emissive triangles.

The triangles lie along a wall, at random in a box, all in one place, or in a stack. The scene also has one large
distant emitter.
Prints the processor seconds of the whole command, which renders 16x16 pixels once.
"""
import array
import json
import pathlib
import random
import resource
import subprocess
import sys
import tempfile

SIDE = .004  # side of a triangle


def corners(kind, count):
    row = int(count**.5)
    numbers = random.Random(1)
    for i in range(count):
        side, other = SIDE, (0, SIDE, 0)
        if kind == "wall":
            at = (i % row * .01, i // row * .01, 0)
        elif kind == "box":
            at = tuple(10 * numbers.random() for _ in range(3))
        elif kind == "one place":
            at = (0, 0, 0)
        else:
            at, side, other = (0, i * 1e-3, 0), 1, (0, 0, 1)
        yield from at
        yield from (at[0] + side, at[1], at[2])
        yield from (a + o for a, o in zip(at, other))
    yield from (1e4, 0, 0, 2e4, 0, 0, 1e4, 1e4, 0)


def write_scene(path, kind, count):
    values = array.array("f", corners(kind, count))
    path.with_suffix(".bin").write_bytes(values.tobytes())
    size = 4 * len(values)
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"emissiveFactor": [1, 1, 1], "doubleSided": True}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(values) // 3,
                       "min": [min(values[k::3]) for k in range(3)],
                       "max": [max(values[k::3]) for k in range(3)]}],
        "bufferViews": [{"buffer": 0, "byteLength": size}],
        "buffers": [{"uri": path.with_suffix(".bin").name, "byteLength": size}]}))


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__.strip())
    counts = [int(n) for n in sys.argv[2:]] or [100_000, 1_000_000]
    print("| | " + " | ".join(f"{n:,}" for n in counts) + " |\n| --- |" + " ---: |" * len(counts))
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "scene.gltf"
        for kind in ("wall", "box", "one place", "stack"):
            row = []
            for count in counts:
                write_scene(scene, kind, count)
                before = resource.getrusage(resource.RUSAGE_CHILDREN)
                subprocess.run([sys.argv[1], "render", scene, "--size", "16x16", "--spp", "1", "--quiet",
                                "-o", pathlib.Path(folder) / "a.exr"], check=True)
                after = resource.getrusage(resource.RUSAGE_CHILDREN)
                row.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
            print(f"| {kind} | " + " | ".join(f"{s:.1f} s" for s in row) + " |", flush=True)


if __name__ == "__main__":
    main()
