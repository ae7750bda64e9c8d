"""Spheres with shadows and textures, after Painter & Sloan 1989, figure 1. A bare spot light casts sharp shadows, and a
large soft box casts soft shadows."""

from . import textures
from .gltf import Gltf, srgb
from .mesh import cylinder, quad, rounded_box, sphere, sweep_wall, torus
from .vec import axis_angle, quaternion_product


def build():
    g = Gltf("Spheres")
    paper = g.material("paper", srgb("#d9ab93"), roughness=0.9)
    terrazzo = g.material("terrazzo", roughness=0.25, texture=g.texture(
        textures.terrazzo("#e9e2d6", ["#b5502f", "#2f4858", "#d29a3e", "#8c8780"]), "terrazzo"))
    plinth = g.material("terracotta", srgb("#b4573a"), roughness=0.75)
    cream = g.material("cream", srgb("#eee2cf"), roughness=0.7)
    marble = g.material("marble", roughness=0.12, texture=g.texture(textures.marble(), "marble"))
    planet = g.material("planet", roughness=0.35, texture=g.texture(textures.planet(), "planet"))
    beach = g.material("stripes", roughness=0.3, texture=g.texture(
        textures.stripes(["#efe6d6", "#c8452a", "#efe6d6", "#e0a030", "#efe6d6", "#23586e"] * 2), "stripes"))
    checker = g.material("checker", roughness=0.2, repeat=(10, 5), texture=g.texture(
        textures.checker("#f0eadc", "#1f3a47"), "checker", nearest=True))
    chrome = g.material("chrome", (0.86, 0.87, 0.88), metallic=1, roughness=0.03)
    gold = g.material("gold", (1.0, 0.74, 0.30), metallic=1, roughness=0.22)
    red = g.material("lacquer", srgb("#b3200f"), roughness=0.06)
    teal = g.material("matt teal", srgb("#2f6f73"), roughness=0.8)

    g.add_object("paper", sweep_wall(9, 5, 4.5, 1.1), paper, translation=(0, 0, 0.9))
    column = cylinder(0.25, 0.42, 72, 0.008).scaled_uv(3.2, 2.0)
    g.add_object("column", column, terrazzo, translation=(-0.20, 0, -0.12))
    low = g.mesh("low plinth", cylinder(0.30, 0.11, 80, 0.008), cream)
    g.node("low plinth", low, translation=(0.42, 0, 0.10))
    g.add_object("block", rounded_box(0.34, 0.26, 0.34, 0.008), plinth, translation=(-0.77, 0.13, 0.02),
          rotation=axis_angle((0, 1, 0), 28))
    g.add_object("ring", torus(0.36, 0.06, 96, 32), teal, translation=(0.62, 0.42, -0.55),
          rotation=quaternion_product(axis_angle((0, 1, 0), -24), axis_angle((1, 0, 0), 90)))

    ball = sphere(1.0, 80, 40)
    meshes = {m: g.mesh(name, ball, m) for name, m in (
        ("marble", marble), ("planet", planet), ("stripes", beach), ("checker", checker), ("chrome", chrome),
        ("gold", gold), ("lacquer", red), ("matt teal", teal), ("cream", cream))}

    def place(name, material, x, y, z, radius, axis=(0, 1, 0), degrees=0.0):
        g.node(name, meshes[material], translation=(x, y + radius, z), scale=radius,
               rotation=axis_angle(axis, degrees))

    place("marble", marble, -0.20, 0.42, -0.12, 0.215, (0.3, 1, 0.2), 60)
    place("planet", planet, 0.42, 0.11, 0.10, 0.19, (0.2, 0.1, 1), -18)
    place("stripes", beach, 0.14, 0, 0.42, 0.115, (1, 0.1, 0.7), 62)
    place("checker", checker, -0.79, 0.26, 0.03, 0.12, (0.2, 0, 1), 24)
    place("chrome", chrome, -0.43, 0, 0.42, 0.105)
    place("lacquer", red, 0.83, 0, 0.27, 0.082)
    place("gold", gold, -0.13, 0, 0.62, 0.055)
    place("teal", teal, 0.50, 0, 0.56, 0.062)
    place("small red", red, -0.68, 0, 0.50, 0.045)
    place("small cream", cream, 0.73, 0, 0.50, 0.035)
    place("small gold", gold, 0.33, 0, 0.66, 0.028)

    g.light("sun", "spot", (1.0, 0.86, 0.70), 75, (-2.9, 2.75, 2.0), (0.1, 0.2, 0), 19, 25)
    g.softbox("soft box", (2.4, 1.9, 2.2), (0, 0.2, 0), quad(1.6, 1.6), (2.3, 2.5, 2.9))
    g.softbox("overhead", (0, 3.4, 0.6), (0, 0, 0), quad(2.4, 1.6), (1.1, 1.08, 1.05), roll_up=(0, 0, -1))
    # A dim surface replaces the rest of the room. Without it, the chrome would reflect blackness.
    g.softbox("room", (0, 3.2, 5.6), (0, 0.2, 0), quad(10, 6), (0.10, 0.105, 0.115))
    g.camera("camera", (0.03, 0.80, 3.3), (0.02, 0.315, 0), 20)
    return g.glb()
