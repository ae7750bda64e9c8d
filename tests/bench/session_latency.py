#!/usr/bin/env python3
"""Measures how soon `emberline session` shows a scene of 100,352 triangles, and a change of camera or material:

    session_latency.py EMBERLINE [SIZE]

The host measures the times, from the command line to the picture event. Prints the median and the range."""
import json, math, os, struct, subprocess, sys, tempfile, time  # noqa: E401

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../renderer/session"))
from example_host import Session  # noqa: E402

SIDE = 224  # quads along one side


def hills(path):
    """Writes a height field of 2 * SIDE^2 triangles, without lights and so under the default white sky."""
    points, normals, triangles = bytearray(), bytearray(), bytearray()
    for z in range(SIDE + 1):
        for x in range(SIDE + 1):
            u, v = x / 9, z / 9
            points += struct.pack("<3f", x / SIDE - 0.5, 0.03 * math.sin(u) * math.cos(v), z / SIDE - 0.5)
            slope = (0.03 * math.cos(u) * math.cos(v) * SIDE / 9, -0.03 * math.sin(u) * math.sin(v) * SIDE / 9)
            length = math.hypot(1, *slope)
            normals += struct.pack("<3f", -slope[0] / length, 1 / length, -slope[1] / length)
    for z in range(SIDE):
        for x in range(SIDE):
            a = z * (SIDE + 1) + x
            triangles += struct.pack("<6I", a, a + SIDE + 1, a + 1, a + 1, a + SIDE + 1, a + SIDE + 2)
    count, views, at = (SIDE + 1) ** 2, [], 0
    for part in (points, normals, triangles):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part)})
        at += len(part)
    accessor = {"componentType": 5126, "count": count, "type": "VEC3"}
    text = json.dumps({
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": at}], "bufferViews": views,
        "accessors": [{"bufferView": 0, **accessor, "min": [-0.5, -0.03, -0.5], "max": [0.5, 0.03, 0.5]},
                      {"bufferView": 1, **accessor},
                      {"bufferView": 2, "componentType": 5125, "count": 6 * SIDE * SIDE, "type": "SCALAR"}],
        "materials": [{"name": "hills", "pbrMetallicRoughness": {"baseColorFactor": [0.4, 0.6, 0.3, 1]}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}],
        "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0}).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + at) + struct.pack("<I4s", len(text), b"JSON") + text +
                   struct.pack("<I4s", at, b"BIN\0") + points + normals + triangles)


def state(name, times):
    times = sorted(1000 * t for t in times)
    print(f"{name}: {times[len(times) // 2]:.1f} ms ({times[0]:.1f} to {times[-1]:.1f}, {len(times)} times)")


def first_picture(session, edit):
    return session.picture(lambda p: p["edit"] >= edit and p["filled"])


def measure(program, size, scene):
    starts, opens, cameras, materials = [], [], [], []
    for _ in range(5):
        begun = time.perf_counter()
        session = Session(program, "--size", size)
        session.receive(lambda m: m.get("event") == "hello")
        starts.append(time.perf_counter() - begun)
        begun = time.perf_counter()
        answer = session.request("open", scene=scene)
        first_picture(session, answer["edit"])
        opens.append(time.perf_counter() - begun)
        view = answer["scene"]["view"]
        for step in range(40):
            time.sleep(0.05)
            moved = {**view, "look_from": [view["look_from"][0] + 0.01 * step, *view["look_from"][1:]]}
            begun = time.perf_counter()
            first_picture(session, session.request("camera", camera=moved)["edit"])
            cameras.append(time.perf_counter() - begun)
            change = {"materials": [{"index": 0, "base_color": [step / 40, 0.5, 0.3]}]}
            begun = time.perf_counter()
            first_picture(session, session.request("edits", edits=change)["edit"])
            materials.append(time.perf_counter() - begun)
        session.send("quit")
        session.process.wait()
    for name, times in (("start to hello", starts), ("open to first picture", opens), ("camera", cameras), ("material", materials)):
        state(f"{size} {name}", times)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        hills(os.path.join(folder, "hills.glb"))
        measure(sys.argv[1], (sys.argv[2:] + ["1280x720"])[0], os.path.join(folder, "hills.glb"))
