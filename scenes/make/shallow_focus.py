"""Chessmen at increasing distances from the camera, with lamps far behind them. The scene shows depth of field: the
camera focuses on the white king, which is 0.58 m away."""

import math
import random

from . import textures
from .gltf import Gltf, srgb
from .mesh import Mesh, arc, floor, lathe, quad, rounded_box, smooth, sphere
from .vec import axis_angle

SQUARE = 0.05


def _foot(r):
    """The mouldings at the base of each piece, up to the start of the body. All pieces share them."""
    return [[(0, 0), (r, 0)], arc((r, 0.0035), 0.0035, -90, 90, 8), [(r, 0.007), (r * 0.93, 0.0085)],
            arc((r * 0.86, 0.0115), 0.0028, -80, 90, 7)]


def _collar(r, y, thick=0.0018):
    return arc((r, y), thick, -90, 90, 7)


def _pawn():
    r = 0.0145
    body = smooth([(r * 0.82, 0.0143), (r * 0.62, 0.019), (r * 0.42, 0.028), (r * 0.36, 0.036)], 6)
    return lathe(_foot(r) + [body, [(r * 0.36, 0.036), (0.0082, 0.0362)], _collar(0.0082, 0.0378, 0.0016),
                             arc((0, 0.0466), 0.0088, -62, 90, 18)], 56)


def _rook():
    r = 0.0165
    body = smooth([(r * 0.84, 0.0143), (r * 0.68, 0.020), (r * 0.56, 0.032), (r * 0.56, 0.044), (r * 0.66, 0.050)], 6)
    mesh = lathe(_foot(r) + [body, _collar(0.0118, 0.0518), [(0.0118, 0.0536), (0.0128, 0.0545), (0.0132, 0.060)],
                             [(0.0132, 0.060), (0.0092, 0.060)], [(0.0092, 0.060), (0.0092, 0.0585)],
                             [(0.0092, 0.0585), (0, 0.0585)]], 56)
    merlon = rounded_box(0.0040, 0.0050, 0.0085, 0.0005, 2)
    for k in range(6):
        a = math.radians(60 * k)
        mesh.append(merlon, (0.0112 * math.cos(a), 0.0622, -0.0112 * math.sin(a)), axis_angle((0, 1, 0), 60 * k))
    return mesh


def _bishop():
    r = 0.0165
    body = smooth([(r * 0.82, 0.0143), (r * 0.60, 0.021), (r * 0.38, 0.034), (r * 0.32, 0.050)], 6)
    mitre = smooth([(0.0048, 0.0560), (0.0088, 0.0610), (0.0092, 0.0665), (0.0062, 0.0750), (0.0022, 0.0796)], 6)
    return lathe(_foot(r) + [body, [(r * 0.32, 0.050), (0.0092, 0.0503)], _collar(0.0092, 0.0520),
                             [(0.0092, 0.0538), (0.0048, 0.0545), (0.0048, 0.0560)], mitre,
                             arc((0, 0.0818), 0.0031, -45, 90, 10)], 56)


def _queen():
    r = 0.0180
    body = smooth([(r * 0.82, 0.0143), (r * 0.60, 0.022), (r * 0.38, 0.040), (r * 0.32, 0.060)], 6)
    crown = smooth([(0.0060, 0.0672), (0.0066, 0.0740), (0.0092, 0.0830), (0.0112, 0.0870)], 6)
    mesh = lathe(_foot(r) + [body, [(r * 0.32, 0.060), (0.0102, 0.0603)], _collar(0.0102, 0.0622, 0.0019),
                             [(0.0102, 0.0641), (0.0060, 0.0650), (0.0060, 0.0672)], crown,
                             arc((0.0104, 0.0876), 0.0009, 0, 120, 5),
                             smooth([(0.0098, 0.0880), (0.0080, 0.0850), (0.0055, 0.0872), (0.0022, 0.0895)], 5),
                             arc((0, 0.0915), 0.0030, -42, 90, 10)], 56)
    bead = sphere(0.0014, 14, 8)
    for k in range(10):
        a = math.radians(36 * k)
        mesh.append(bead, (0.0106 * math.cos(a), 0.0886, -0.0106 * math.sin(a)))
    return mesh


def _king():
    r = 0.0185
    body = smooth([(r * 0.82, 0.0143), (r * 0.61, 0.022), (r * 0.40, 0.042), (r * 0.34, 0.066)], 6)
    head = smooth([(0.0064, 0.0730), (0.0070, 0.0800), (0.0096, 0.0900), (0.0102, 0.0925)], 6)
    mesh = lathe(_foot(r) + [body, [(r * 0.34, 0.066), (0.0108, 0.0663)], _collar(0.0108, 0.0682, 0.0019),
                             [(0.0108, 0.0701), (0.0064, 0.0710), (0.0064, 0.0730)], head,
                             smooth([(0.0102, 0.0925), (0.0088, 0.0950), (0.0052, 0.0968), (0.0026, 0.0980)], 5),
                             [(0.0026, 0.0980), (0.0022, 0.0990), (0, 0.0990)]], 56)
    mesh.append(rounded_box(0.0030, 0.0135, 0.0026, 0.0006, 2), (0, 0.1050, 0))
    return mesh.append(rounded_box(0.0098, 0.0030, 0.0026, 0.0006, 2), (0, 0.1065, 0))


def build():
    g = Gltf("Shallow focus")
    maple = g.material("maple", srgb("#e2c18d"), roughness=0.30)
    ebony = g.material("ebony", srgb("#2c1c15"), roughness=0.22)
    light = g.material("light squares", roughness=0.26, texture=g.texture(
        textures.wood(textures.OAK, 256, 2, 21, seams=False), "oak"))
    dark = g.material("dark squares", roughness=0.26, texture=g.texture(
        textures.wood(textures.WALNUT, 256, 2, 22, seams=False), "walnut"))
    table = g.material("table", srgb("#1c1512"), roughness=0.4)
    wall = g.material("night wall", srgb("#3b4a66"), roughness=0.95)

    squares = (Mesh(), Mesh())
    tile = floor(SQUARE, SQUARE, 5.3)
    for j in range(8):
        for i in range(8):
            mesh = squares[(i + j) % 2]
            start = len(mesh.uvs)
            mesh.append(tile, ((i - 3.5) * SQUARE, 0, (j - 3.5) * SQUARE))
            mesh.uvs[start:] = [(u + 0.37 * i + 0.11 * j, v + 0.29 * j + 0.17 * i) for u, v in mesh.uvs[start:]]
    board = [g.node("dark squares", g.mesh("dark squares", squares[1], dark), root=False),
             g.node("light squares", g.mesh("light squares", squares[0], light), root=False),
             g.node("frame", g.mesh("frame", rounded_box(0.46, 0.022, 0.46, 0.003), ebony), root=False,
                    translation=(0, -0.0114, 0))]
    men = {"pawn": _pawn(), "rook": _rook(), "bishop": _bishop(), "queen": _queen(), "king": _king()}
    meshes = {}
    position = [  # (kind, is white, file, rank); rank 0 is nearest to the camera
        ("king", True, 3, 2), ("queen", False, 4, 4), ("pawn", True, 4, 1), ("pawn", True, 2, 1),
        ("rook", True, 6, 3), ("bishop", True, 1, 3), ("pawn", False, 3, 4), ("pawn", False, 5, 5),
        ("bishop", False, 2, 5), ("rook", False, 7, 7), ("king", False, 5, 7), ("rook", False, 1, 7),
        ("pawn", False, 0, 6), ("pawn", False, 6, 6), ("pawn", True, 5, 2), ("pawn", False, 1, 5),
        ("pawn", False, 7, 5), ("queen", True, 0, 4)]
    for k, (kind, white, file, rank) in enumerate(position):
        key = (kind, white)
        if key not in meshes:
            meshes[key] = g.mesh(f"{'white' if white else 'black'} {kind}", men[kind], maple if white else ebony)
        board.append(g.node(f"man {k + 1}: {kind}", meshes[key], root=False,
                            rotation=axis_angle((0, 1, 0), 23 + 47 * k),
                            translation=((file - 3.5) * SQUARE, 0, (3.5 - rank) * SQUARE)))
    g.node("board", children=board, rotation=axis_angle((0, 1, 0), 17))
    g.add_object("table", rounded_box(3, 0.04, 1.4, 0.01), table, translation=(0, -0.0424, -0.3))
    g.add_object("wall", quad(14, 6), wall, translation=(0, 1.2, -4.4))

    source = random.Random(12)
    bulb = sphere(1.0, 16, 8)
    bulbs = [g.mesh(name, bulb, g.material(name, (0, 0, 0), roughness=1, emission=e)) for name, e in (
        ("warm lamp", (4.2, 1.8, 0.5)), ("amber lamp", (4.4, 1.2, 0.16)), ("cool lamp", (0.7, 1.6, 3.4)),
        ("red lamp", (3.4, 0.28, 0.16)))]
    for k in range(46):
        x, y, z = (source.random() - 0.5) * 2.6, -0.06 + 0.55 * source.random(), -2.2 - 1.8 * source.random()
        pick = source.random()
        which = 0 if pick < 0.5 else 1 if pick < 0.75 else 2 if pick < 0.9 else 3
        g.node(f"lamp {k + 1}", bulbs[which], translation=(x, y, z), scale=0.013 + 0.009 * source.random())
    g.softbox("key", (-0.55, 0.60, 0.30), (0, 0.03, 0), quad(0.35, 0.35), (18, 15.0, 11.6))
    g.softbox("wall wash", (0.3, -0.55, -3.5), (0.2, 0.5, -4.4), quad(2.4, 0.3), (0.9, 1.1, 1.6))
    g.softbox("rim", (0.55, 0.40, -0.55), (0, 0.05, 0), quad(0.20, 0.45), (9, 10.5, 13))
    g.camera("camera", (0.03, 0.118, 0.66), (-0.010, 0.048, 0.0), 20)
    return g.glb()
