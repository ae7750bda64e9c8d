"""Converts the patches of Newell's teapot to a triangle mesh with exact surface normals."""

import math

from .mesh import Mesh
from .teapot_data import PATCHES, POINTS
from .vec import add, cross, length, mul, normalize


def _bernstein(t):
    s = 1 - t
    return (s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t)


def _bernstein_slope(t):
    s = 1 - t
    return (-3 * s * s, 3 * s * s - 6 * t * s, 6 * t * s - 3 * t * t, 3 * t * t)


def _blend(points, row_weights, column_weights):
    out = (0.0, 0.0, 0.0)
    for j in range(4):
        for i in range(4):
            out = add(out, mul(points[4 * j + i], row_weights[j] * column_weights[i]))
    return out


def _normal(points, u, v):
    """Returns the surface normal. The cross product vanishes where a side of the patch is collapsed to a point, at the
    lid's knob and at the bottom. There, returns the normal at a small distance along v or, on the axis, the direction
    of the axis."""
    du = _blend(points, _bernstein(v), _bernstein_slope(u))
    dv = _blend(points, _bernstein_slope(v), _bernstein(u))
    n = cross(du, dv)
    if length(n) > 1e-4:
        return normalize(n)
    inside = v + (1e-3 if v < 0.5 else -1e-3)
    n = normalize(cross(_blend(points, _bernstein(inside), _bernstein_slope(u)),
                        _blend(points, _bernstein_slope(inside), _bernstein(u))))
    p = _blend(points, _bernstein(v), _bernstein(u))
    if math.hypot(p[0], p[1]) < 1e-6:
        return (0.0, 0.0, math.copysign(1.0, n[2]))
    return n


def _mirrored(points, x, y):
    """Mirrors a patch in x, in y or in both. A single reflection turns the patch inside out, so its rows are then
    reversed."""
    out = [(px * x, py * y, pz) for px, py, pz in points]
    if x * y < 0:
        out = [out[4 * j + 3 - i] for j in range(4) for i in range(4)]
    return out


# In the published data, the lid's rim has a radius of 1.3 and does not touch the pot's rim, whose radius is 1.4. The
# surface has no thickness, and its back faces are visible inside the pot. So its material should be two-sided.
def teapot(cells, parts=None):
    """Returns a mesh of all 32 patches, or only of the patches that `parts` names. Each patch has cells x cells quads.
    The teapot stands on the plane y = 0, y points up, and the spout points towards +x."""
    mesh = Mesh()
    for name, quarters, indices in PATCHES:
        if parts and name not in parts:
            continue
        base = [tuple(float(c) for c in POINTS[k]) for k in indices]
        signs = [(1, 1), (-1, 1), (1, -1), (-1, -1)] if quarters else [(1, 1), (1, -1)]
        for sx, sy in signs:
            points = _mirrored(base, sx, sy)
            def point(u, v, points=points):
                p = _blend(points, _bernstein(v), _bernstein(u))
                n = _normal(points, u, v)
                return (p[0], p[2], -p[1]), (n[0], n[2], -n[1]), (1 - u, v)
            mesh.grid(cells, cells, point)
    return mesh
