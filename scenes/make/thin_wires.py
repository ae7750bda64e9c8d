"""A cable-stayed bridge under dusk.hdr. At 1280 x 720, its stays are about 1/2 pixel thick, the railing 1/5 pixel, and
the chains of lamps and the ties across the stays 1/20 pixel. All wires share the mesh of one unit tube."""

import math

from . import noise, textures
from .gltf import Gltf, srgb
from .mesh import Mesh, floor, rounded_box, sphere, tube
from .vec import add, facing, length, lerp, sub

DECK = 19.0  # metres above the water
TOWERS = (-95.0, 95.0)
TOP = 92.0
STAYS = 16
# The radii of the wires are in metres. At the near tower, 310 m from the camera, a pixel of a 1280 x 720 frame covers
# 0.21 m.
STAY, RAIL, HAIR = 0.052, 0.021, 0.0052


def _hills(seed, width, depth, height):
    """A ridge along x that faces the camera. It is a height field and looks right only from the front."""
    field = noise.fractal(256, 8, 7, 1, 5, seed, 0.5)

    def crest(u):
        return height * (0.25 + 0.75 * noise.sample(field, u * 255, 2)) * math.sin(math.pi * u) ** 0.4

    def at(u, v):
        return ((u - 0.5) * width, crest(min(max(u, 0.0), 1.0)) * math.sin(v * math.pi / 2), -depth * v)

    def point(u, v):
        e = 1e-3
        du = sub(at(min(u + e, 1.0), v), at(max(u - e, 0.0), v))
        dv = sub(at(u, min(v + e, 1.0)), at(u, max(v - e, 0.0)))
        n = (du[1] * dv[2] - du[2] * dv[1], du[2] * dv[0] - du[0] * dv[2], du[0] * dv[1] - du[1] * dv[0])
        return at(u, v), n, (u, v)
    return Mesh().grid(220, 6, point)


def build():
    g = Gltf("Thin wires")
    waves = noise.fractal(256, 256, 6, 6, 4, 77, 0.55)
    water = g.material("water", srgb("#1d2a30"), roughness=0.07,
                       normal=g.texture(textures.normal_map(waves, 3.0, 40), "waves"), normal_scale=0.28)
    concrete = g.material("concrete", srgb("#a79f95"), roughness=0.8)
    steel = g.material("steel", srgb("#3a3d42"), metallic=0, roughness=0.5)
    wire = g.material("wire", srgb("#d8d2c8"), metallic=0, roughness=0.5)
    lamp = g.material("lamp", (0, 0, 0), roughness=1, emission=(34, 20, 8.5))
    near_hill = g.material("near hill", srgb("#4a4450"), roughness=1)
    far_hill = g.material("far hill", srgb("#7d7078"), roughness=1)

    g.add_object("water", floor(9000, 9000, 1 / 60, cells=12), water, translation=(0, 0, -3000))
    g.add_object("far hills", _hills(5, 6200, 400, 330), far_hill, translation=(-300, -2, -3300))
    g.add_object("near hills", _hills(9, 4200, 300, 130), near_hill, translation=(900, -2, -1900))

    # All parts of the bridge are children of one node. The node is rotated, so that the bridge crosses the line of
    # sight obliquely.
    parts = []

    def part(name, mesh, **placement):
        parts.append(g.node(name, mesh, root=False, **placement))

    strand = g.mesh("strand", tube([(0, 0, 0), (0, 0, 1)], 1.0, 8, caps=False), wire)

    def wire_between(name, a, b, radius):
        span = sub(b, a)
        part(name, strand, translation=a, rotation=facing(span), scale=(radius, radius, length(span)))

    part("deck", g.mesh("deck", rounded_box(620, 1.6, 13, 0.3), concrete), translation=(0, DECK - 0.8, 0))
    part("girder", g.mesh("girder", rounded_box(620, 1.4, 6, 0.3), steel), translation=(0, DECK - 2.3, 0))
    leg = g.mesh("leg", rounded_box(3.4, 1.0, 2.6, 0.18), concrete)
    pier = g.mesh("pier", rounded_box(9, 8, 20, 1.0), concrete)
    for t, x in enumerate(TOWERS):
        part(f"pier {t + 1}", pier, translation=(x, 1.0, 0))
        for s, z in enumerate((-8.5, 8.5)):  # the legs form an A: they lean inwards and almost meet near the top
            foot, head = (x, 3.0, z), (x, TOP * 0.80, math.copysign(1.2, z))
            lean = math.degrees(math.atan2(foot[2] - head[2], head[1] - foot[1]))
            part(f"leg {t + 1}{'ab'[s]}", leg, translation=lerp(foot, head, 0.5),
                 scale=(1, length(sub(head, foot)) + 1.0, 1),
                 rotation=(math.sin(math.radians(-lean) / 2), 0, 0, math.cos(math.radians(-lean) / 2)))
        part(f"mast {t + 1}", leg, translation=(x, TOP * 0.90, 0), scale=(1.05, TOP * 0.24, 1.4))
        for side in (-1, 1):
            ends = []
            for k in range(STAYS):
                f = (k + 1) / STAYS
                high = (x, TOP * 0.80 + TOP * 0.19 * f, 0)
                low = (x + side * (10 + 84 * f), DECK, 0)
                ends.append((high, low))
                for z in (-5.6, 5.6):
                    wire_between(f"stay {t + 1}.{side}.{k + 1}.{z}", high, add(low, (0, 0, z)), STAY)
            for f in (0.35, 0.6):  # hair-thin ties cross the stays
                for (h0, l0), (h1, l1) in zip(ends, ends[1:]):
                    wire_between("tie", lerp(h0, add(l0, (0, 0, 5.6)), f), lerp(h1, add(l1, (0, 0, 5.6)), f), HAIR)
    for z in (-6.2, 6.2):
        for h in (0.5, 1.0):
            wire_between("rail", (-310, DECK + h, z), (310, DECK + h, z), RAIL)
    bulb = g.mesh("bulb", sphere(0.34, 12, 6), lamp)
    previous = None
    for k in range(49):  # lamps on posts along the deck, with hair-thin chains that sag between them
        x = -300 + 12.5 * k
        p = (x, DECK + 5.2, 6.2)
        part("lamp", bulb, translation=p)
        wire_between("post", (x, DECK, 6.2), p, 0.05)
        if previous:
            for n in range(6):
                a, b = n / 6, (n + 1) / 6
                sag = [(lerp(previous, p, s)[0], p[1] - 4 * 1.4 * s * (1 - s), 6.2) for s in (a, b)]
                wire_between("chain", sag[0], sag[1], HAIR)
        previous = p
    g.node("bridge", rotation=(0, math.sin(math.radians(24) / 2), 0, math.cos(math.radians(24) / 2)), children=parts,
           translation=(0, 0, -40))
    g.camera("camera", (-8, 9.0, 300), (2, 41, -40), 27, near=0.5)
    g.rotate_scene(27)  # so that the camera looks towards the sun of dusk.hdr
    return g.glb()
