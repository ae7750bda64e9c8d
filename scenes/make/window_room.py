"""A room that is lit through glass: sky light comes through a double window, and the light of a bulb comes through a
glass globe. Drinking glasses stand on the table. All glass is smooth and thin-walled (KHR_materials_transmission
without _volume)."""

from .gltf import Gltf, srgb
from .mesh import Mesh, arc, cylinder, lathe, quad, rounded_box, smooth, sphere
from .vec import axis_angle

LEFT, RIGHT, LOW, HIGH = -1.35, 0.55, 0.85, 2.05  # edges of the window in x and y; its wall is at z = -2


def _wall_with_window():
    """The wall around the window, facing +Z. It reaches from -2 to 2 in x and from 0 to 2.6 in y."""
    mesh = Mesh()
    for x0, x1, y0, y1 in ((-2, LEFT, 0, 2.6), (RIGHT, 2, 0, 2.6), (LEFT, RIGHT, 0, LOW), (LEFT, RIGHT, HIGH, 2.6)):
        mesh.append(quad(x1 - x0, y1 - y0), translation=((x0 + x1) / 2, (y0 + y1) / 2, -2))
    return mesh


def _reveal():
    """The four sides of the window's opening. They are 12 cm deep and face inwards."""
    width, height, depth = RIGHT - LEFT, HIGH - LOW, 0.12
    x, y, z = (LEFT + RIGHT) / 2, (LOW + HIGH) / 2, -2 - depth / 2
    mesh = Mesh()
    mesh.append(quad(width, depth), translation=(x, LOW, z), rotation=axis_angle((1, 0, 0), -90))
    mesh.append(quad(width, depth), translation=(x, HIGH, z), rotation=axis_angle((1, 0, 0), 90))
    mesh.append(quad(depth, height), translation=(LEFT, y, z), rotation=axis_angle((0, 1, 0), 90))
    mesh.append(quad(depth, height), translation=(RIGHT, y, z), rotation=axis_angle((0, 1, 0), -90))
    return mesh


def _frame():
    """The frame of the window: four bars, a mullion and a sill."""
    width, height = RIGHT - LEFT, HIGH - LOW
    x, y = (LEFT + RIGHT) / 2, (LOW + HIGH) / 2
    upright, level = rounded_box(0.05, height, 0.05, 0.004), rounded_box(width, 0.05, 0.05, 0.004)
    mesh = Mesh()
    for at in (LEFT + 0.025, x, RIGHT - 0.025):
        mesh.append(upright, translation=(at, y, -2.08))
    for at in (LOW + 0.025, HIGH - 0.025):
        mesh.append(level, translation=(x, at, -2.0799))
    mesh.append(rounded_box(width + 0.1, 0.03, 0.2, 0.006), translation=(x, LOW - 0.015, -1.93))
    return mesh


def _tumbler():
    """A drinking glass, 11 cm high. Its profile goes up the outside, over the rim and down the inside. The renderer
    treats each of its surfaces as a thin sheet."""
    return lathe([[(0, 0), (0.029, 0)], arc((0.029, 0.002), 0.002, -90, 0, 3), [(0.031, 0.002), (0.036, 0.110)],
                  arc((0.0352, 0.110), 0.0008, 0, 180, 5), [(0.0344, 0.110), (0.0296, 0.010)],
                  [(0.0296, 0.010), (0, 0.010)]], 48)


def _carafe():
    outside = smooth([(0.045, 0.0), (0.055, 0.03), (0.052, 0.09), (0.030, 0.15), (0.022, 0.20), (0.027, 0.25)], 5)
    inside = smooth([(0.0255, 0.25), (0.0205, 0.20), (0.0285, 0.15), (0.0505, 0.09), (0.0535, 0.03), (0.044, 0.003)], 5)
    return lathe([[(0, 0), (0.045, 0)], outside, inside, [(0.044, 0.003), (0, 0.003)]], 56)


def _table():
    mesh = rounded_box(1.3, 0.035, 0.7, 0.006)
    for x in (-0.58, 0.58):
        for z in (-0.28, 0.28):
            mesh.append(rounded_box(0.05, 0.70, 0.05, 0.004), translation=(x, -0.3675, z))
    return mesh


def build():
    g = Gltf("Window room")
    plaster = g.material("plaster", srgb("#e4dfd4"), roughness=0.95)
    boards = g.material("boards", srgb("#9a7350"), roughness=0.45)
    paint = g.material("paint", srgb("#f2f1ec"), roughness=0.35)
    oak = g.material("oak", srgb("#b98a55"), roughness=0.4)
    blue = g.material("blue wall", srgb("#5d7f96"), roughness=0.95)
    pane = g.material("pane", (0.97, 0.99, 0.98), roughness=0.0, transmission=1)
    glass = g.material("drinking glass", (0.99, 0.99, 0.99), roughness=0.0, transmission=1)
    green = g.material("green glass", (0.45, 0.80, 0.55), roughness=0.0, transmission=1)
    orange = g.material("orange", srgb("#dd7a1c"), roughness=0.5)
    brass = g.material("brass", (0.89, 0.72, 0.39), metallic=1, roughness=0.25)

    g.add_object("floor", quad(4, 4), boards, rotation=axis_angle((1, 0, 0), -90))
    g.add_object("ceiling", quad(4, 4), plaster, translation=(0, 2.6, 0), rotation=axis_angle((1, 0, 0), 90))
    g.add_object("window wall", _wall_with_window(), plaster)
    g.add_object("left wall", quad(4, 2.6), plaster, translation=(-2, 1.3, 0), rotation=axis_angle((0, 1, 0), 90))
    g.add_object("right wall", quad(4, 2.6), blue, translation=(2, 1.3, 0), rotation=axis_angle((0, 1, 0), -90))
    g.add_object("back wall", quad(4, 2.6), plaster, translation=(0, 1.3, 2), rotation=axis_angle((0, 1, 0), 180))
    g.add_object("reveal", _reveal(), paint)
    g.add_object("frame", _frame(), paint)
    for name, z in (("outer pane", -2.092), ("inner pane", -2.068)):
        g.add_object(name, quad(RIGHT - LEFT, HIGH - LOW), pane, translation=((LEFT + RIGHT) / 2, (LOW + HIGH) / 2, z))

    g.add_object("table", _table(), oak, translation=(0.35, 0.72, -0.45))
    top = 0.7377  # things stand 0.2 mm above the table
    tumbler = g.mesh("tumbler", _tumbler(), glass)
    for number, (x, z) in enumerate(((0.12, -0.36), (0.62, -0.28), (0.47, -0.58))):
        g.node(f"tumbler {number}", tumbler, translation=(x, top, z))
    g.add_object("carafe", _carafe(), green, translation=(0.27, top, -0.56))
    ball = g.mesh("orange", sphere(1.0, 40, 20), orange)
    for number, (x, z, r) in enumerate(((0.78, -0.52, 0.040), (0.86, -0.44, 0.037), (-0.04, -0.50, 0.039))):
        g.node(f"orange {number}", ball, translation=(x, top + r, z), scale=r)

    lamp = (1.15, 1.75, -0.9)
    bulb = g.material("bulb", (0, 0, 0), roughness=1.0, emission=(1000, 700, 420))
    g.add_object("bulb", sphere(0.02, 20, 10), bulb, translation=lamp)
    g.add_object("globe", sphere(0.09, 48, 24), glass, translation=lamp)
    g.add_object("cap", cylinder(0.03, 0.05, 32, 0.003), brass, translation=(lamp[0], lamp[1] + 0.086, lamp[2]))
    g.add_object("rod", cylinder(0.004, 2.6 - lamp[1] - 0.13, 12), brass, translation=(lamp[0], lamp[1] + 0.13, lamp[2]))
    g.camera("camera", (0.35, 1.45, 1.75), (0.12, 1.02, -1.0), 50)
    return g.glb()
