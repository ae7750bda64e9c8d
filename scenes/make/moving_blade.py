"""A desk fan that shows motion blur and --time. The animation "blades" turns its blades four times per second."""

import math

from . import textures
from .gltf import Gltf, srgb
from .mesh import Mesh, arc, cylinder, lathe, quad, rounded_box, smooth, torus, tube
from .vec import add, axis_angle, cross, mul, normalize, quaternion_product, rotate, sub

BLADES = 4


def _blade():
    """One blade of a rotor around +Z. It is a closed mesh: a twisted, cambered leaf that is 1.6 mm thick."""
    def middle(s, t):
        """Returns a point halfway between the blade's two sides. s increases along the radius and t across it, both in
        [0, 1]."""
        r = 0.026 + 0.112 * s
        width = 0.030 + 0.062 * math.sin(math.pi * min(1.0, 0.12 + 0.80 * s)) ** 0.8
        if s > 0.8:
            width *= math.sqrt(max(0.0, 1 - ((s - 0.8) / 0.2) ** 2 * 0.80))
        across = (t - 0.5) * width
        pitch = math.radians(38 - 16 * s)
        camber = 0.010 * (1 - (2 * t - 1) ** 2) * s
        a = across * math.cos(pitch) / r + 0.35 * s  # the blade is swept forward
        return (r * math.cos(a), r * math.sin(a), across * math.sin(pitch) + camber)

    def normal(s, t):
        e = 1e-3
        ds = sub(middle(min(s + e, 1), t), middle(max(s - e, 0), t))
        dt = sub(middle(s, min(t + e, 1)), middle(s, max(t - e, 0)))
        return normalize(cross(ds, dt))

    half = 0.0008
    mesh = Mesh()
    mesh.grid(28, 16, lambda u, v: (add(middle(u, v), mul(normal(u, v), half)), normal(u, v), (u, v)))
    mesh.grid(28, 16, lambda u, v: (sub(middle(1 - u, v), mul(normal(1 - u, v), half)), mul(normal(1 - u, v), -1),
                                    (1 - u, v)))
    edges = [lambda w: (w, 0.0), lambda w: (1.0, w), lambda w: (1 - w, 1.0), lambda w: (0.0, 1 - w)]
    for edge in edges:
        def point(u, v, edge=edge):
            s, t = edge(u)
            n = normal(s, t)
            e = 1e-2
            a, b = edge(max(0.0, u - e)), edge(min(1.0, u + e))
            along = normalize(sub(middle(*b), middle(*a)))
            return add(middle(s, t), mul(n, half * (2 * v - 1))), cross(along, n), (u, v)
        mesh.grid(24, 1, point)
    return mesh


def _turned(mesh):
    """Rotates a mesh whose axis is y, as lathe() makes it, so that its axis becomes z, the axis of the fan."""
    return Mesh().append(mesh, rotation=axis_angle((1, 0, 0), 90))


def _spoke(z_sign):
    """One wire of the cage. It runs from the badge outwards and bends to the rim."""
    path = smooth([(0.030, 0, 0.052), (0.060, 0, 0.0535), (0.100, 0, 0.0490), (0.132, 0, 0.036), (0.1475, 0, 0.014),
                   (0.1500, 0, 0.0)], 4)
    return tube([(x, y, z * z_sign) for x, y, z in path], 0.0009, 6)


def build():
    g = Gltf("Moving blade")
    enamel = g.material("enamel", srgb("#2d6b63"), roughness=0.16)
    brass = g.material("brass", (0.91, 0.69, 0.36), metallic=1, roughness=0.20)
    wire = g.material("nickel wire", (0.74, 0.71, 0.66), metallic=1, roughness=0.22)
    desk = g.material("oak desk", roughness=0.38, texture=g.texture(textures.wood(textures.OAK, 512, 3, 9), "oak"))
    wall = g.material("wall", srgb("#d7c4a3"), roughness=0.9, normal=g.texture(textures.plaster(seed=4), "plaster"),
                      normal_scale=0.45)
    rubber = g.material("felt", srgb("#22201e"), roughness=0.95)

    g.add_object("desk", rounded_box(2.0, 0.04, 0.8, 0.005, uv_per_unit=1.6), desk, translation=(0, -0.02, -0.02))
    g.add_object("wall", quad(4, 2.4, (5, 3)), wall, translation=(0, 0.6, -0.42))

    base = smooth([(0.078, 0.006), (0.0775, 0.012), (0.070, 0.020), (0.044, 0.028), (0.020, 0.042), (0.0135, 0.064),
                   (0.0120, 0.100), (0.0125, 0.118)], 6)
    g.add_object("felt", cylinder(0.074, 0.004, 72), rubber)
    g.add_object("base", lathe([[(0, 0.004), (0.076, 0.004)], arc((0.076, 0.006), 0.002, -90, 0, 4), base,
                         [(0.0125, 0.118), (0, 0.118)]], 80), enamel)
    g.add_object("dial", cylinder(0.011, 0.010, 40, 0.002), brass, translation=(0, 0.0215, 0.058),
          rotation=axis_angle((1, 0, 0), 24))

    # The head is tilted up slightly and turned to the light. All its parts are children of one node and use that node's
    # axes.
    head = []

    def part(name, mesh, **placement):
        head.append(g.node(name, mesh, root=False, **placement))

    motor = smooth([(0.0, -0.150), (0.020, -0.148), (0.040, -0.138), (0.050, -0.115), (0.052, -0.085),
                    (0.047, -0.056), (0.036, -0.045)], 6)
    part("motor", g.mesh("motor", _turned(lathe([motor, [(0.036, -0.045), (0, -0.045)]], 80)), enamel))
    part("band", g.mesh("band", _turned(torus(0.0523, 0.0022, 80, 12)), brass), translation=(0, 0, -0.090))
    neck = g.mesh("neck", cylinder(0.0145, 0.075, 40, 0.003), brass)
    part("neck", neck, translation=(0, -0.115, -0.095))
    part("badge", g.mesh("badge", _turned(lathe([[(0, -0.003), (0.031, -0.003)], arc((0.031, 0), 0.003, -90, 90, 6),
                                                 smooth([(0.031, 0.003), (0.022, 0.0055), (0.0, 0.0075)], 6)], 64)),
                         brass), translation=(0, 0, 0.052))
    for sign, name in ((1, "front"), (-1, "back")):
        spoke = g.mesh(f"{name} spoke", _spoke(sign), wire)
        for k in range(32):
            part(f"{name} spoke {k + 1}", spoke, rotation=axis_angle((0, 0, 1), 360 * (k + 0.5 * (sign < 0)) / 32))
        part(f"{name} ring", g.mesh(f"{name} ring", _turned(torus(0.102, 0.0012, 96, 8)), wire),
             translation=(0, 0, 0.0488 * sign))
    part("rim", g.mesh("rim", _turned(torus(0.1505, 0.0026, 128, 12)), wire))
    part("hub", g.mesh("hub", _turned(lathe([[(0, -0.045), (0.006, -0.045), (0.006, -0.02)],
                                             [(0.006, -0.02), (0.0275, -0.02), (0.0285, -0.016), (0.0285, 0.010)],
                                             smooth([(0.0285, 0.010), (0.024, 0.020), (0.012, 0.0255), (0, 0.027)], 5)],
                                            56)), brass))
    blade = g.mesh("blade", _blade(), brass)
    leaves = [g.node(f"blade {k + 1}", blade, rotation=axis_angle((0, 0, 1), 360 * k / BLADES), root=False)
              for k in range(BLADES)]
    rest = axis_angle((0, 0, 1), 17)
    rotor = g.node("rotor", children=leaves, rotation=rest, root=False)
    head.append(rotor)
    pose = quaternion_product(axis_angle((0, 1, 0), -16), axis_angle((1, 0, 0), -6))
    g.node("head", children=head, rotation=pose,  # the neck sits on the stand
           translation=sub((0, 0.114, 0), rotate(pose, (0, -0.115, -0.095))))

    books = ((0.20, 0.028, 0.145, "#8f2f22", 12), (0.185, 0.022, 0.13, "#26465c", 5),
             (0.165, 0.018, 0.12, "#c99a3c", 21))
    for k, (w, h, d, colour, turn) in enumerate(books):
        y = sum(b[1] for b in books[:k]) + h / 2
        cover = g.material(f"book {k + 1}", srgb(colour), roughness=0.55)
        pages = g.material(f"pages {k + 1}", srgb("#e9dfc8"), roughness=0.9)
        spin = axis_angle((0, 1, 0), turn)
        centre = (0.285, y, -0.06)
        g.add_object(f"pages {k + 1}", rounded_box(w - 0.010, h - 0.005, d - 0.006, 0.0005), pages,
              translation=add(centre, rotate(spin, (0.001, 0, 0.0005))), rotation=spin)
        for part_name, offset, size in (("top", (0, h / 2 - 0.00125, 0), (w, 0.0025, d)),
                                        ("bottom", (0, -h / 2 + 0.00125, 0), (w, 0.0025, d)),
                                        ("spine", (-w / 2 + 0.00125, 0, 0), (0.0025, h, d))):
            g.add_object(f"{part_name} {k + 1}", rounded_box(*size, 0.0010), cover,
                  translation=add(centre, rotate(spin, offset)), rotation=spin)
    cup = g.material("mug", srgb("#e8e0d0"), roughness=0.25)
    mug = lathe([[(0, 0), (0.036, 0)], arc((0.036, 0.004), 0.004, -90, 0, 4), [(0.040, 0.004), (0.040, 0.088)],
                 arc((0.0385, 0.088), 0.0015, 0, 180, 6), [(0.037, 0.088), (0.037, 0.010), ],
                 arc((0.033, 0.010), 0.004, 0, -90, 4), [(0.033, 0.006), (0, 0.006)]], 72)
    handle = tube(smooth([(0.038, 0.070, 0), (0.060, 0.072, 0), (0.069, 0.048, 0), (0.060, 0.024, 0),
                          (0.038, 0.022, 0)], 8), 0.0052, 16, caps=False)
    g.add_object("mug", mug.append(handle), cup, translation=(-0.245, 0, 0.02), rotation=axis_angle((0, 1, 0), 215))

    g.softbox("window", (-1.15, 0.85, 0.55), (0, 0.15, 0), quad(0.7, 1.2), (17, 17, 17),
              g.texture(textures.window(), "window"))
    g.softbox("fill", (1.3, 0.6, 1.3), (0, 0.2, 0), quad(1.6, 1.6), (1.7, 1.6, 1.5))
    g.softbox("rim", (0.75, 0.80, -0.25), (0, 0.2, 0), quad(0.2, 0.6), (6.5, 5.6, 4.4))
    quarter = [quaternion_product(axis_angle((0, 0, 1), 90 * k), rest) for k in range(5)]
    g.animate_rotation("blades", rotor, [k / 16 for k in range(5)], quarter)
    g.camera("camera", (0.10, 0.30, 1.2), (0.012, 0.204, 0), 22.4)
    return g.glb()
