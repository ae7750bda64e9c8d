"""A wet street at night, with hundreds of lamps far behind a bollard. The camera has a wide aperture and focuses on the
bollard. The lamps are small, bright and out of focus. Their radiances range from that of a lit window to that of a
headlamp."""

import random

from .gltf import Gltf, srgb
from .mesh import arc, floor, lathe, quad, rounded_box, sphere
from .vec import axis_angle

_COLOURS = (("sodium", (1.0, 0.45, 0.10)), ("window", (1.0, 0.72, 0.42)), ("headlamp", (0.85, 0.95, 1.0)),
            ("brake", (1.0, 0.05, 0.03)), ("signal", (0.05, 1.0, 0.45)))
_RADIANCES = (0.5, 8, 150, 3000, 60000)


def _bollard():
    return lathe([[(0, 0), (0.055, 0)], [(0.055, 0), (0.048, 0.62)], arc((0.046, 0.64), 0.012, -60, 90, 8),
                  [(0.046, 0.652), (0.040, 0.66)], arc((0, 0.66), 0.040, 0, 90, 12)], 48)


def build():
    g = Gltf("Night street")
    road = g.material("wet road", srgb("#3a3a3e"), roughness=0.22)
    brick = g.material("walls", srgb("#6b4a3c"), roughness=0.9)
    iron = g.material("iron", srgb("#25282c"), roughness=0.35)
    paint = g.material("car paint", srgb("#7a1a18"), roughness=0.15)
    g.add_object("road", floor(30, 80), road, translation=(0, 0, -38))
    for side in (-1, 1):
        g.add_object(f"houses {side}", rounded_box(4, 14, 70, 0.05), brick, translation=(9 * side, 7, -38))
    g.add_object("house at the end", quad(18, 14), brick, translation=(0, 7, -74))
    bollard = g.mesh("bollard", _bollard(), iron)
    for k, (x, z) in enumerate(((0.06, -1.2), (-0.9, -2.6), (1.3, -4.4), (-2.1, -7.5))):
        g.node(f"bollard {k + 1}", bollard, translation=(x, 0, z))
    body, cabin = rounded_box(1.8, 0.7, 4.2, 0.25, 5), rounded_box(1.5, 0.6, 2.1, 0.25, 5)
    body.append(cabin, (0, 0.55, 0.2))
    car = g.mesh("car", body, paint)
    for k, (x, z) in enumerate(((2.9, -13), (-3.2, -20), (3.0, -33))):
        g.node(f"car {k + 1}", car, translation=(x, 0.55, z), rotation=axis_angle((0, 1, 0), 4 * k - 3))

    source = random.Random(1989)
    bulb = sphere(1.0, 10, 6)
    meshes = {}
    for k in range(260):
        # Brighter lamps are smaller: each step has 20 times the radiance and about a third of the radius.
        step = min(4, int(5 * source.random() ** 1.5))
        which = int(len(_COLOURS) * source.random())
        if (step, which) not in meshes:
            name, colour = _COLOURS[which]
            emission = tuple(_RADIANCES[step] * c for c in colour)
            lamp = g.material(f"{name} {_RADIANCES[step]:g}", (0, 0, 0), roughness=1, emission=emission)
            meshes[step, which] = g.mesh(f"{name} {_RADIANCES[step]:g}", bulb, lamp)
        x, y, z = 13 * (source.random() - 0.5), 0.3 + 6.5 * source.random() ** 2, -10 - 60 * source.random()
        g.node(f"lamp {k + 1}", meshes[step, which], translation=(x, y, z), scale=0.16 / 3.2 ** step)
    g.camera("camera", (0.0, 0.72, 0.0), (0.02, 0.70, -1.2), 34)
    return g.glb()
