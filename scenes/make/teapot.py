"""Newell's teapot on a textured table, lit by area lights, after Painter & Sloan 1989, figure 1."""

from . import textures
from .gltf import Gltf, srgb
from .mesh import arc, disc, lathe, quad, rounded_box, smooth
from .newell import teapot
from .vec import axis_angle


def _cup():
    """A small bowl without a handle, 4.6 cm high."""
    outside = smooth([(0.019, 0.0015), (0.020, 0.004), (0.030, 0.016), (0.0372, 0.034), (0.0385, 0.046)], 6)
    inside = smooth([(0.0368, 0.0462), (0.0355, 0.034), (0.0283, 0.0175), (0.016, 0.0085), (0, 0.0075)], 6)
    return lathe([[(0, 0.003), (0.015, 0.003)], [(0.015, 0.003), (0.0165, 0.0), (0.018, 0.0), (0.019, 0.0015)],
                  outside, arc((0.03765, 0.0461), 0.00085, 0, 180, 6), inside], 72)


def _lemon():
    return lathe([smooth([(0, -0.041), (0.0045, -0.0395), (0.011, -0.034), (0.0225, -0.021), (0.0275, 0.0),
                          (0.0225, 0.021), (0.012, 0.0335), (0.0058, 0.038), (0.0048, 0.0415), (0, 0.0435)], 5)], 48)


def build():
    g = Gltf("Teapot")
    table = g.material("walnut table", roughness=0.34, texture=g.texture(textures.wood(textures.WALNUT), "walnut"))
    wall = g.material("painted wall", srgb("#4c6f70"), roughness=0.85,
                      normal=g.texture(textures.plaster(), "plaster"), normal_scale=0.5)
    glaze = g.material("ember glaze", srgb("#c2410f"), roughness=0.13, two_sided=True)
    china = g.material("china", srgb("#ece3d2"), roughness=0.22)
    tea = g.material("tea", srgb("#8f3d0e"), roughness=0.03)
    rind = g.material("lemon", srgb("#e8b41c"), roughness=0.38,
                      normal=g.texture(textures.hammered(128, 480, 9, 3.0), "rind"), normal_scale=0.6,
                      repeat=(2, 2))

    g.add_object("table", rounded_box(2.2, 0.05, 1.0, 0.006, uv_per_unit=1.7), table, translation=(0, -0.025, -0.05))
    g.add_object("wall", quad(5, 3, (6, 3.6)), wall, translation=(0, 0.7, -0.75))
    g.add_object("teapot", teapot(14), glaze, translation=(-0.045, 0, 0), rotation=axis_angle((0, 1, 0), 24), scale=0.05)

    cup = g.mesh("cup", _cup(), china)
    surface = g.mesh("tea", disc(0.0352, 72), tea)
    for k, (x, z) in enumerate(((0.178, 0.105), (0.272, 0.005))):
        g.node(f"cup {k + 1}", cup, translation=(x, 0, z))
        g.node(f"tea {k + 1}", surface, translation=(x, 0.034, z))
    lemon = g.mesh("lemon", _lemon(), rind)
    lying = axis_angle((0, 0, 1), 90)
    g.node("lemon 1", lemon, translation=(-0.190, 0.0273, 0.150), rotation=lying)
    g.node("lemon 2", lemon, translation=(-0.248, 0.0262, 0.095), scale=0.96,
           rotation=axis_angle((0.25, 0.45, 1), 98))

    pane = g.texture(textures.window(), "window")
    g.softbox("window", (-1.25, 0.95, 0.55), (0, 0.08, 0), quad(0.9, 1.35), (23, 23, 23), pane)
    g.softbox("fill", (1.7, 0.7, 1.3), (0, 0.1, 0), quad(1.4, 1.4), (0.55, 0.5, 0.45))
    g.softbox("rim", (0.85, 0.75, -0.55), (0, 0.1, 0), quad(0.25, 0.7), (5.5, 4.6, 3.4))
    g.camera("camera", (0.02, 0.37, 1.2), (-0.004, 0.06, 0), 17.6)
    return g.glb()
