"""A gold ring and a glass ball on a table, lit by one small bulb. Only paths that hit the bulb by chance render the
caustics inside the ring and behind the ball."""

from .gltf import Gltf, srgb
from .mesh import arc, lathe, sphere, sweep_wall


def _ring():
    """A ring 12 cm in diameter and 3 cm high, with a wall of 3 mm."""
    return lathe([[(0.060, 0.0), (0.060, 0.0285)], arc((0.0585, 0.0285), 0.0015, 0, 180, 6),
                  [(0.057, 0.0285), (0.057, 0.0)]], 96)


def build():
    g = Gltf("Caustics")
    table = g.material("table", srgb("#b8aa98"), roughness=0.85)
    gold = g.material("gold", (1.0, 0.76, 0.33), metallic=1, roughness=0.06)
    glass = g.material("glass", (1, 1, 1), roughness=0.0, transmission=1, ior=1.5, attenuation=((0.95, 0.98, 1.0), 0.1))
    bulb = g.material("bulb", (0, 0, 0), roughness=1, emission=(650, 560, 440))
    g.add_object("table and wall", sweep_wall(2.4, 1.2, 1.2, 0.2), table)
    g.add_object("ring", _ring(), gold, translation=(-0.075, 0.0002, 0.02))
    ball = g.mesh("ball", sphere(1.0, 96, 48), glass)
    g.node("ball", ball, translation=(0.085, 0.0402, 0.0), scale=0.04)
    g.node("bulb", g.mesh("bulb", sphere(1.0, 24, 12), bulb), translation=(0.26, 0.30, 0.22), scale=0.015)
    g.softbox("window", (-0.9, 0.7, 0.9), (0, 0, 0), sphere(0.25, 24, 12), (0.7, 0.85, 1.1))
    g.camera("camera", (0.0, 0.34, 0.46), (0.0, 0.005, 0.0), 30)
    return g.glb()
