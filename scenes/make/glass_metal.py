"""A still life in glass and metal on marble. The glass uses KHR_materials_transmission, _ior and _volume;
renderers without these extensions show porcelain."""

from . import textures
from .gltf import Gltf, srgb
from .mesh import arc, lathe, quad, rounded_box, smooth, sphere, sweep_wall
from .vec import axis_angle


def _wine_glass():
    """A wine glass, 20.5 cm high, with a wall of 1.2 mm. Its profile is closed: it goes up the outside, over the rim,
    and down the inside."""
    foot = smooth([(0.0365, 0.0022), (0.030, 0.0036), (0.014, 0.0072), (0.0060, 0.014), (0.0042, 0.030),
                   (0.0040, 0.060), (0.0045, 0.078), (0.0085, 0.0885), (0.0210, 0.0990), (0.0340, 0.118),
                   (0.0395, 0.140), (0.0385, 0.165), (0.0345, 0.190), (0.0318, 0.205)], 4)
    bowl = smooth([(0.0306, 0.205), (0.0333, 0.190), (0.0373, 0.165), (0.0383, 0.140), (0.0328, 0.1190),
                   (0.0205, 0.1012), (0.0080, 0.0935), (0.0, 0.0918)], 5)
    return lathe([[(0, 0), (0.0355, 0)], arc((0.0355, 0.0011), 0.0011, -90, 60, 5), foot,
                  arc((0.0312, 0.2051), 0.0006, 0, 180, 6), bowl], 64)


def _wine():
    """The wine in the glass. It reaches a height of 14 cm, with a gap of 0.1 mm between wine and glass."""
    side = smooth([(0.0, 0.0919), (0.0079, 0.0936), (0.0204, 0.1013), (0.0327, 0.1191), (0.0382, 0.1400)], 6)
    return lathe([side, [(0.0382, 0.1400), (0.0, 0.1400)]], 64)


def _carafe():
    """A decanter, 24 cm high, with a wall of 3 mm and a heavy bottom."""
    outside = smooth([(0.046, 0.004), (0.052, 0.020), (0.0545, 0.050), (0.047, 0.085), (0.031, 0.118),
                      (0.0205, 0.145), (0.0180, 0.175), (0.0200, 0.210), (0.0290, 0.240)], 5)
    inside = smooth([(0.0268, 0.2405), (0.0172, 0.209), (0.0150, 0.175), (0.0176, 0.145), (0.0282, 0.1165),
                     (0.0440, 0.0838), (0.0513, 0.050), (0.0480, 0.026), (0.032, 0.0165), (0.0, 0.0150)], 5)
    return lathe([[(0, 0), (0.042, 0)], arc((0.042, 0.004), 0.004, -90, 0, 5), outside,
                  arc((0.0279, 0.2405), 0.0011, 0, 180, 6), inside], 64)


def _pot():
    """A beaten copper bowl, 9 cm high, with a wall of 2 mm."""
    outside = smooth([(0.034, 0.0), (0.050, 0.008), (0.066, 0.032), (0.0695, 0.058), (0.064, 0.082),
                      (0.0655, 0.090)], 6)
    inside = smooth([(0.0635, 0.0903), (0.0618, 0.082), (0.0673, 0.058), (0.064, 0.033), (0.049, 0.011),
                     (0.0, 0.004)], 6)
    return lathe([[(0, 0), (0.034, 0)], outside, arc((0.0645, 0.0902), 0.001, 0, 180, 6), inside], 64, (12, 5))


def _tin():
    """A brushed steel canister with a knob."""
    return lathe([[(0, 0), (0.040, 0)], arc((0.040, 0.002), 0.002, -90, 0, 4), [(0.042, 0.002), (0.042, 0.100)],
                  arc((0.0410, 0.1005), 0.0012, -20, 90, 4), [(0.0405, 0.1017), (0.0405, 0.104)],
                  arc((0.0425, 0.106), 0.002, -90, 0, 4), [(0.0445, 0.106), (0.0445, 0.116)],
                  arc((0.0415, 0.116), 0.003, 0, 90, 5), [(0.0415, 0.119), (0.006, 0.119)],
                  smooth([(0.006, 0.119), (0.0052, 0.124), (0.0095, 0.131), (0.0095, 0.136), (0.0, 0.1405)], 5)],
                 64, (1, 3))


def build():
    g = Gltf("Glass and metal")
    marble = g.material("marble", roughness=0.13, texture=g.texture(textures.marble(seed=12), "marble"))
    wall = g.material("wall", srgb("#3d4a55"), roughness=0.9)
    glass = g.material("glass", (1, 1, 1), roughness=0.0, transmission=1, ior=1.5,
                       attenuation=((0.93, 0.97, 0.95), 0.05))
    green = g.material("green glass", (1, 1, 1), roughness=0.0, transmission=1, ior=1.52,
                       attenuation=((0.22, 0.62, 0.52), 0.012))
    wine = g.material("wine", (1, 1, 1), roughness=0.0, transmission=1, ior=1.34,
                      attenuation=((0.72, 0.16, 0.06), 0.018))
    gold = g.material("gold", (1.0, 0.72, 0.29), metallic=1, roughness=0.16)
    copper = g.material("beaten copper", (0.95, 0.58, 0.42), metallic=1, roughness=0.17,
                        normal=g.texture(textures.hammered(), "dents"), normal_scale=0.55)
    chrome = g.material("chrome", (0.88, 0.89, 0.90), metallic=1, roughness=0.02)
    steel = g.material("brushed steel", (0.62, 0.61, 0.60), metallic=1, roughness=0.55,
                       roughness_texture=g.texture(textures.brushed(), "brushed"))

    g.add_object("table", rounded_box(1.5, 0.04, 0.8, 0.006, uv_per_unit=1.35), marble, translation=(0, -0.02, -0.05))
    g.add_object("wall", sweep_wall(6, 3, 3, 0.6), wall, translation=(0, -0.9, 0.3))
    gap = 0.0002  # between glass and marble, because coincident surfaces would look wrong through the glass
    g.add_object("carafe", _carafe(), green, translation=(-0.020, gap, -0.085))
    g.add_object("wine glass", _wine_glass(), glass, translation=(0.105, gap, 0.005))
    g.add_object("wine", _wine(), wine, translation=(0.105, gap, 0.005))
    g.add_object("copper bowl", _pot(), copper, translation=(-0.150, 0, 0.010))
    g.add_object("canister", _tin(), steel, translation=(0.222, 0, -0.070), rotation=axis_angle((0, 1, 0), 35))
    ball = sphere(1.0, 56, 28)
    for name, material, x, z, r in (
            ("chrome ball", chrome, 0.030, 0.095, 0.028), ("gold ball", gold, -0.052, 0.085, 0.021),
            ("glass ball", glass, 0.195, 0.075, 0.030), ("small gold", gold, 0.092, 0.118, 0.011),
            ("small chrome", chrome, -0.232, 0.085, 0.013), ("green ball", green, -0.105, 0.115, 0.014)):
        g.node(name, g.mesh(name, ball, material), translation=(x, r + gap, z), scale=r)
    g.add_object("gold block", rounded_box(0.05, 0.05, 0.05, 0.003), gold, translation=(-0.262, 0.025, -0.045),
          rotation=axis_angle((0, 1, 0), 33))

    soft = g.texture(textures.soft_edge(), "diffuser")
    g.softbox("key", (-0.85, 0.65, 0.35), (0, 0.08, 0), quad(0.7, 0.9), (13, 13, 13), soft)
    g.softbox("strip", (0.75, 0.45, -0.30), (0, 0.1, 0), quad(0.14, 0.9), (9, 10, 11.5))
    g.softbox("overhead", (0.05, 1.15, -0.1), (0, 0, 0), quad(0.9, 0.35), (4.2, 4.0, 3.7), roll_up=(0, 0, -1))
    g.softbox("wall wash", (0.15, -0.35, -0.62), (0.1, 0.35, -1.2), quad(0.9, 0.2), (26, 22, 17))
    g.softbox("room", (0, 1.0, 2.2), (0, 0.1, 0), quad(4.5, 2.6), (0.20, 0.205, 0.22))
    g.softbox("front fill", (0.5, 0.7, 1.6), (0, 0.1, 0), quad(1.4, 0.8), (0.5, 0.5, 0.55))
    g.camera("camera", (0.0, 0.235, 0.95), (-0.012, 0.101, 0), 20)
    return g.glb()
