"""Two rows of spheres under studio.hdr: gold in front, and a red dielectric behind. Their roughness increases from left
to right: 0, 0.1, ... 1."""

from . import textures
from .gltf import Gltf, srgb
from .mesh import rounded_box, sphere

COUNT = 11
RADIUS = 0.122
SPACING = 0.274
STEP = 0.17


def build():
    g = Gltf("Roughness spheres")
    stone = g.material("dark marble", roughness=0.16, texture=g.texture(
        textures.marble(textures.DARK_MARBLE, seed=19), "dark marble"))
    ball = sphere(RADIUS, 72, 36)
    for k in range(COUNT):
        r = k / (COUNT - 1)
        x = SPACING * (k - (COUNT - 1) / 2)
        gold = g.material(f"gold, roughness {r:.1f}", (1.0, 0.71, 0.29), metallic=1, roughness=r)
        red = g.material(f"red, roughness {r:.1f}", srgb("#a3160e"), roughness=r)
        g.add_object(f"gold {r:.1f}", ball, gold, translation=(x, RADIUS, 0.42))
        g.add_object(f"red {r:.1f}", ball, red, translation=(x, RADIUS + STEP, -0.28))
    g.add_object("stage", rounded_box(9, 0.10, 5.2, 0.012, uv_per_unit=0.45), stone, translation=(0, -0.05, 1.0))
    g.add_object("step", rounded_box(3.5, STEP, 0.66, 0.012, uv_per_unit=0.45), stone, translation=(0, STEP / 2, -0.28))
    g.camera("camera", (0, 1.42, 5.6), (0, 0.2, 0), 18.6)
    return g.glb()
