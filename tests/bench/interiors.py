#!/usr/bin/env python3
"""Compares frames with and without --guiding at equal processor time, in rooms that are hard to light.

Renders each scene with `--guiding off` and with `--guiding on`, and prints

  error   relMSE without over that with guiding, at the same --spp, without the worst thousandth of the pixels
  time    processor seconds with guiding, including the survey, over those without
  gain    error / time: how many times less processor time guiding needs for an equal error
  worst   the same as error, for the worst thousandth alone

An error is half the squared difference of two frames with different seeds, so there are no references.
The rooms are made by this script. Constants were chosen on `screen`, `corridor`, `uplight` and three other scenes; the
last four were made afterwards. Further scenes can be given as JSON lines:
{"name": "cornell", "scene": "cornell_box.glb", "options": []}.

  PYTHONPATH=build/release/python tests/bench/interiors.py build/release/bin/emberline rooms --spp 64

With --blender, Cycles renders the scenes too. The last two columns are how many times less processor time Emberline
needs than Cycles, without and with guiding. Emberline's time is then that of the whole process, Cycles' begins with its
first sample. Lamps are two-sided, as always in Cycles; both use eight bounces and a box filter. The options of
further scenes must then begin with --look-from, --look-at and --fov-y, and can have --env and --env-strength.
"""
import argparse
import json
import os
import subprocess
import sys
import types
from pathlib import Path

try:
    import numpy as np

    import emberline
except ImportError:  # the rooms need neither
    pass

import race_cycles

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scenes"))
from make.gltf import Gltf, srgb  # noqa: E402
from make.mesh import Mesh, cylinder, lathe, quad, sphere  # noqa: E402
from make.vec import axis_angle  # noqa: E402


def face(mesh, axis, at, low, high, towards):
    """Adds a rectangle with the coordinate `at` on `axis` (0 to 2), whose other coordinates reach from `low` to `high`.
    It faces the direction `towards` (1 or -1) along the axis."""
    (a0, b0), (a1, b1) = low, high
    centre = [(a0 + a1) / 2, (b0 + b1) / 2]
    centre.insert(axis, at)
    if axis == 0:
        shape, turn = quad(b1 - b0, a1 - a0), axis_angle((0, 1, 0), 90 * towards)
    elif axis == 1:
        shape, turn = quad(a1 - a0, b1 - b0), axis_angle((1, 0, 0), -90 * towards)
    else:
        shape, turn = quad(a1 - a0, b1 - b0), axis_angle((0, 1, 0), 0 if towards > 0 else 180)
    return mesh.append(shape, translation=tuple(centre), rotation=turn)


def box(low, high, inwards=False, without=()):
    """A box. `without` lists the faces to leave out, as (axis, side)."""
    mesh = Mesh()
    for axis in range(3):
        rest = [i for i in range(3) if i != axis]
        for side in (0, 1):
            if (axis, side) not in without:
                face(mesh, axis, (low, high)[side][axis], [low[i] for i in rest], [high[i] for i in rest],
                     (1 if side else -1) * (-1 if inwards else 1))
    return mesh


def wall_with_hole(mesh, axis, at, low, high, hole_low, hole_high, towards):
    """Adds a wall with a rectangular hole."""
    (a0, b0), (a1, b1), (c0, d0), (c1, d1) = low, high, hole_low, hole_high
    for first, last in (((a0, b0), (c0, b1)), ((c1, b0), (a1, b1)), ((c0, b0), (c1, d0)), ((c0, d1), (c1, b1))):
        if first[0] < last[0] and first[1] < last[1]:
            face(mesh, axis, at, first, last, towards)
    return mesh


class Room(Gltf):
    two_sided_lamps = False

    def __init__(self, name):
        super().__init__(name)
        self.plaster = self.material("plaster", (0.75, 0.75, 0.72), roughness=1.0, two_sided=True)
        self.boards = self.material("boards", srgb("#8a6a4a"), roughness=0.5, two_sided=True)
        self.red = self.material("red", (0.6, 0.2, 0.15), roughness=1.0, two_sided=True)
        self.green = self.material("green", (0.2, 0.4, 0.25), roughness=1.0, two_sided=True)
        self.brass = self.material("brass", (0.89, 0.72, 0.39), metallic=1.0, roughness=0.3)

    def lamp(self, mesh, radiance, **placement):
        glow = self.material("lamp", (0, 0, 0), roughness=1.0, emission=tuple(radiance * c for c in (1, 0.9, 0.8)),
                             two_sided=self.two_sided_lamps)
        return self.add_object("lamp", mesh, glow, **placement)

    def camera(self, name, look_from, look_at, fov_y):
        triple = lambda x: ",".join(map(str, x))
        self.view = ["--look-from", triple(look_from), "--look-at", triple(look_at), "--fov-y", str(fov_y)]
        return super().camera(name, look_from, look_at, fov_y)

    def shell(self, high, without=()):
        """Adds the walls, floor and ceiling of a room with a corner at the origin."""
        self.add_object("walls", box((0, 0, 0), high, True, ((1, 0),) + tuple(without)), self.plaster)
        self.add_object("floor", face(Mesh(), 1, 0, (0, 0), (high[0], high[2]), 1), self.boards)


def screen():
    """A lamp behind a screen."""
    r = Room("screen")
    r.shell((5, 2.8, 4))
    r.add_object("screen", box((3.2, 0, 0.6), (3.25, 1.9, 2.6)), r.red)
    r.lamp(face(Mesh(), 0, 4.6, (0.9, 1.2), (1.2, 1.6), -1), 40)
    r.add_object("box", box((1.2, 0, 1), (2, 0.7, 1.8)), r.green)
    r.camera("camera", (0.3, 1.5, 3.7), (2.5, 1, 1.2), 65)
    return r


def corridor():
    """A corridor with an open door at its end. The lamp of the room behind the door is out of sight."""
    r = Room("corridor")
    r.shell((2, 2.5, 8), ((2, 0),))
    r.add_object("wall", wall_with_hole(Mesh(), 2, 0, (-1, 0), (3, 2.5), (0.6, 0), (1.4, 2), 1), r.plaster)
    r.add_object("bright room", box((-1, 0, -4), (3, 2.5, 0), True, ((2, 1),)), r.plaster)
    r.lamp(face(Mesh(), 0, 2.9, (1, -0.8), (1.6, -0.3), -1), 40)
    r.add_object("chest", box((1.2, 0, 3), (1.8, 0.8, 3.5)), r.red)
    r.add_object("cupboard", box((0.1, 0, 4.5), (0.5, 1.4, 5.2)), r.green)
    r.camera("camera", (1, 1.5, 7.6), (1, 1.1, 2), 60)
    return r


def uplight():
    """A lamp that shines only on the ceiling."""
    r = Room("uplight")
    r.shell((5, 2.8, 4))
    r.add_object("bowl", box((2.2, 1.8, 1.7), (2.8, 2, 2.3), False, ((1, 1),)), r.red)
    r.lamp(face(Mesh(), 1, 1.82, (2.25, 1.75), (2.75, 2.25), 1), 40)
    r.add_object("table", box((1, 0, 1), (1.8, 0.75, 2)), r.green)
    r.add_object("cupboard", box((3.5, 0, 0.5), (4.3, 1.2, 1.1)), r.red)
    r.camera("camera", (0.3, 1.6, 3.7), (3, 0.9, 1.2), 65)
    return r


def shade():
    """A bulb in a lampshade that is open at the top and the bottom."""
    r = Room("shade")
    r.shell((4, 2.6, 4))
    lining = r.material("lining", (0.8, 0.75, 0.65), roughness=1.0, two_sided=True)
    tube = lathe([[(0.18, 0), (0.18, 0.3)]], 48)
    r.add_object("shade", tube, lining, translation=(2.6, 1.3, 1.2))
    r.lamp(sphere(0.03, 24, 12), 400, translation=(2.6, 1.42, 1.2))
    r.add_object("table", box((2.1, 0, 0.7), (3.1, 1.0, 1.7)), r.boards)
    r.add_object("vase", sphere(0.15, 48, 24), r.brass, translation=(2.9, 1.15, 1.5))
    r.add_object("sofa", box((0.3, 0, 0.4), (1.2, 0.6, 2.4)), r.red)
    r.camera("camera", (1.2, 1.5, 3.8), (2.2, 1.0, 1.0), 62)
    return r


def shaft():
    """An attic lit by the sky and the sun through a deep shaft in its ceiling. Render it with --sun."""
    r = Room("shaft")
    r.shell((4, 2.4, 4), ((1, 1),))
    r.add_object("ceiling", wall_with_hole(Mesh(), 1, 2.4, (0, 0), (4, 4), (2.4, 1.2), (3, 1.8), -1), r.plaster)
    r.add_object("shaft", box((2.4, 2.4, 1.2), (3, 3.6, 1.8), True, ((1, 0), (1, 1))), r.plaster)
    r.add_object("chest", box((1.5, 0, 0.6), (2.3, 0.6, 1.2)), r.green)
    r.add_object("crate", box((2.5, 0, 2.2), (3.2, 0.9, 2.9)), r.red)
    r.camera("camera", (0.3, 1.5, 3.7), (2.6, 0.7, 1.2), 65)
    return r


def ajar():
    """A dark room next to a lit one; the door between them is ajar. The floor and a cupboard are glossy."""
    r = Room("ajar")
    r.shell((4, 2.5, 3), ((0, 1),))
    r.add_object("wall", wall_with_hole(Mesh(), 0, 4, (0, 0), (2.5, 3), (0, 1), (2, 1.9), -1), r.plaster)
    r.add_object("lit room", box((4.1, 0, 0), (7, 2.5, 3), True, ((0, 0),)), r.plaster)
    r.add_object("its wall", wall_with_hole(Mesh(), 0, 4.1, (0, 0), (2.5, 3), (0, 1), (2, 1.9), 1), r.plaster)
    door = box((0, 0, 0), (0.04, 2, 0.9))
    r.add_object("door", door, r.boards, translation=(4.0, 0, 1.0), rotation=axis_angle((0, 1, 0), 20))
    r.lamp(face(Mesh(), 1, 2.49, (5.2, 1.2), (5.8, 1.8), -1), 30)
    r.add_object("cupboard", box((1.2, 0, 0.1), (2.2, 1.2, 0.6)), r.brass)
    r.camera("camera", (0.4, 1.5, 2.7), (3.2, 0.9, 1.0), 66)
    return r


def cove():
    """Indirect lamps behind ledges along two walls of a hall with pillars."""
    r = Room("cove")
    r.shell((8, 3, 5))
    for x0, x1 in ((0, 0.25), (7.75, 8)):
        r.add_object("ledge", box((x0, 2.5, 0), (x1, 2.55, 5)), r.plaster)
        r.lamp(face(Mesh(), 1, 2.56, (x0 + 0.1, 0.2), (x0 + 0.15, 4.8), 1), 60)
    for x in (2, 4, 6):
        r.add_object("pillar", cylinder(0.2, 3, 48), r.plaster, translation=(x, 0, 1.2))
    r.add_object("bench", box((2.6, 0, 2.2), (5.2, 0.45, 2.7)), r.red)
    r.add_object("ball", sphere(0.35, 48, 24), r.brass, translation=(5.9, 0.35, 2.6))
    r.camera("camera", (0.6, 1.6, 4.7), (4.6, 1.0, 1.0), 62)
    return r


ROOMS = {room.__name__: room for room in (screen, corridor, uplight, shade, shaft, ajar, cove)}
OPTIONS = {"shaft": ["--sun", "60,30", "--env-strength", "1"]}


def read(path):
    picture = emberline.read(path)
    return np.stack([picture[c] for c in "RGB"], -1).astype(float)


def render(program, scene, output, size, spp, seed, guiding):
    """Returns the linear picture and the processor seconds."""
    before = os.times()
    subprocess.run([program, "render", *scene, "--size", size, "--spp", str(spp), "--seed", str(seed), "--guiding",
                    guiding, "-o", output, "--quiet"], check=True)
    after = os.times()
    return read(output), after.children_user + after.children_system - before.children_user - before.children_system


def render_with_cycles(blender, scene, output, size, spp, seed):
    """Does the same with Cycles."""
    given = dict(zip(scene[1::2], scene[2::2]))
    numbers = lambda name: [float(x) for x in given[name].split(",")]
    view = {"look_from": numbers("--look-from"), "look_at": numbers("--look-at"), "fov_y": float(given["--fov-y"]),
            "env": given.get("--env"), "env_strength": float(given.get("--env-strength", 1))}
    options = types.SimpleNamespace(assets=Path(), blender=blender, threads=os.cpu_count(), bounces=8,
                                    cache=output.parent.resolve())
    figures = race_cycles.Cycles(options, view).render(Path(scene[0]).resolve(), size, spp, seed, output.resolve())
    return read(output), figures["render_cpu_s"]


def smoothed(picture):
    """The mean over 3x3 pixels."""
    for axis in (0, 1):
        padded = np.concatenate([picture.take([0], axis), picture, picture.take([-1], axis)], axis)
        picture = sum(padded.take(range(i, i + picture.shape[axis]), axis) for i in range(3)) / 3
    return picture


def split_mean(values):
    """The means without the greatest thousandth, and of the greatest thousandth."""
    values = np.sort(values.ravel())
    split = len(values) - len(values) // 1000
    return values[:split].mean(), values[split:].mean()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="the emberline binary")
    parser.add_argument("folder", type=Path, help="folder for the rooms and the frames")
    parser.add_argument("--rooms", default=",".join(ROOMS), help="names of rooms")
    parser.add_argument("--scenes", type=Path, help="file of further scenes")
    parser.add_argument("--spp", default="64", help="samples per pixel [64]")
    parser.add_argument("--size", default="320x180", help="size of the frames [320x180]")
    parser.add_argument("--pairs", type=int, default=1, help="pairs of frames [1]")
    parser.add_argument("--blender", help="a Blender whose Cycles renders the scenes, too")
    parser.add_argument("--guiding", default="on", choices=("on", "auto"), help="what to compare with off [on]")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    Room.two_sided_lamps = options.blender is not None
    scenes = {}
    for name in filter(None, options.rooms.split(",")):
        path = options.folder / f"{name}.glb"
        room = ROOMS[name]()
        path.write_bytes(room.glb())
        scenes[name] = [str(path), *room.view, *OPTIONS.get(name, [])]
    for line in options.scenes.read_text().splitlines() if options.scenes else []:
        row = json.loads(line)
        scenes[row["name"]] = [str(options.scenes.parent / row["scene"]), *row.get("options", [])]
    heads = ["scene", "spp", "relMSE without", "with", "time without", "error", "time", "gain", "worst"]
    heads += ["without / Cycles", "with / Cycles"] if options.blender else []
    print("| " + " | ".join(heads) + " |\n" + "| --- " * len(heads) + "|")
    output = options.folder / "frame.exr"
    as_cycles = ["--filter", "box", "--max-depth", "9"] if options.blender else []
    for name, scene in scenes.items():
        for spp in map(int, options.spp.split(",")):
            ways = {way: lambda seed, way=way: render(options.program, scene + as_cycles, output, options.size, spp,
                                                      seed, way) for way in (options.guiding, "off")}
            if options.blender:
                ways["Cycles"] = lambda seed: render_with_cycles(options.blender, scene, output, options.size, spp, seed)
            errors, worst, seconds, scale = {}, {}, {}, None
            for way, frame in ways.items():
                runs = [frame(seed) for seed in range(1, 2 * options.pairs + 1)]
                pictures, seconds[way] = [run[0] for run in runs], sum(run[1] for run in runs) / len(runs)
                if scale is None:  # the least noisy frames give the scale of all
                    mean = smoothed(sum(pictures) / len(pictures))
                    scale = 2 * (mean ** 2 + 0.01 * mean.mean() ** 2)
                errors[way], worst[way] = np.mean([split_mean(((a - b) ** 2 / scale).mean(-1))
                                                   for a, b in zip(pictures[::2], pictures[1::2])], axis=0)
            ratio = lambda values, way, other="off": values[other] / values[way]
            gain = lambda way, other="off": ratio(errors, way, other) * ratio(seconds, way, other)
            on = options.guiding
            cells = [name, spp, f"{errors['off']:.3g}", f"{errors[on]:.3g}", f"{seconds['off']:.1f} s",
                     *(f"{x:.2f}" for x in (ratio(errors, on), 1 / ratio(seconds, on), gain(on), ratio(worst, on)))]
            cells += [f"{gain(way, 'Cycles'):.2f}" for way in ("off", on)] if options.blender else []
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()
