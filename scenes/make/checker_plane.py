"""A checkered plane that reaches the horizon, which is the classic test for aliasing. It is lit by dusk.hdr, with long
shadows. On it stand a mirror ball and columns that shrink in the distance."""

from . import textures
from .gltf import Gltf, srgb
from .mesh import arc, floor, lathe, rounded_box, smooth, sphere, torus
from .vec import axis_angle, quaternion_product


def _column():
    """A 6 m column with a base, a swelling shaft and a capital. This mesh is round, so the square plinth is a separate
    mesh."""
    shaft = smooth([(0.40, 0.62), (0.405, 1.6), (0.395, 3.0), (0.365, 4.4), (0.335, 5.4)], 5)
    return lathe([[(0.0, 0.22), (0.46, 0.22)], arc((0.46, 0.32), 0.10, -90, 90, 8),
                  [(0.46, 0.42), (0.44, 0.47)], arc((0.43, 0.54), 0.06, -70, 90, 6), [(0.43, 0.60), (0.40, 0.62)],
                  shaft, arc((0.345, 5.45), 0.045, -90, 90, 6),
                  smooth([(0.335, 5.50), (0.36, 5.62), (0.46, 5.72)], 4), [(0.46, 5.72), (0.46, 5.76), (0, 5.76)]], 48)


def build():
    g = Gltf("Checker plane")
    checks = g.material("checks", roughness=0.42, texture=g.texture(
        textures.checker("#e6d9c3", "#2b3138"), "checks", nearest=True))
    stone = g.material("stone", roughness=0.62, texture=g.texture(
        textures.marble([(0, (150, 128, 108)), (0.3, (214, 196, 172)), (1, (236, 224, 204))], 256, 31), "stone"))
    chrome = g.material("chrome", (0.90, 0.91, 0.92), metallic=1, roughness=0.0)
    ember = g.material("ember", srgb("#c8401a"), roughness=0.18)
    ochre = g.material("ochre", srgb("#dfa23a"), roughness=0.5)
    blue = g.material("blue", srgb("#1f4f7a"), roughness=0.12)

    g.add_object("plane", floor(6000, 6000, 0.5, cells=24), checks, translation=(0, 0, 0))
    column = g.mesh("column", _column().scaled_uv(2, 3), stone)
    plinth = g.mesh("plinth", rounded_box(1.25, 0.22, 1.25, 0.03, uv_per_unit=0.6), stone)
    slab = g.mesh("slab", rounded_box(1.1, 0.24, 1.1, 0.03, uv_per_unit=0.6), stone)
    finial = g.mesh("finial", sphere(0.42, 48, 24), ember)
    for k in range(24):
        x, z = 4.9, -5.0 - 6.0 * k
        g.node(f"column {k + 1}", column, translation=(x, 0, z), rotation=axis_angle((0, 1, 0), 47.0 * k))
        g.node(f"plinth {k + 1}", plinth, translation=(x, 0.11, z))
        g.node(f"slab {k + 1}", slab, translation=(x, 5.88, z))
        g.node(f"finial {k + 1}", finial, translation=(x, 6.42, z))
    ball = sphere(1.0, 96, 48)
    mirror = g.mesh("mirror ball", ball, chrome)
    g.node("mirror ball", mirror, translation=(-1.5, 1.5, 0), scale=1.5)
    for name, material, x, z, r in (("blue ball", blue, 1.15, 3.4, 0.55), ("ochre ball", ochre, -4.4, 2.6, 0.42),
                                    ("small ember ball", ember, 0.1, 4.9, 0.24),
                                    ("far ball", ochre, -9.5, -16, 1.6)):
        g.node(name, g.mesh(name, ball, material), translation=(x, r, z), scale=r)
    g.add_object("ring", torus(1.25, 0.24, 96, 32), ember, translation=(-6.3, 1.49, -6.0),
          rotation=quaternion_product(axis_angle((0, 1, 0), 30), axis_angle((1, 0, 0), 90)))
    g.camera("camera", (0.4, 2.35, 15.5), (0.1, 2.1, 0), 28)
    return g.glb()
