"""Vectors are tuples, and rotations are glTF quaternions (x, y, z, w)."""

import math


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def mul(a, s):
    return tuple(x * s for x in a)


def lerp(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def normalize(a):
    n = length(a)
    return mul(a, 1.0 / n) if n > 0 else a


def axis_angle(axis, degrees):
    half = math.radians(degrees) / 2
    x, y, z = mul(normalize(axis), math.sin(half))
    return (x, y, z, math.cos(half))


def quaternion_product(a, b):
    """Returns the rotation that applies b first, then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def rotate(q, v):
    u, w = q[:3], q[3]
    return add(add(mul(u, 2 * dot(u, v)), mul(v, w * w - dot(u, u))), mul(cross(u, v), 2 * w))


def from_basis(x, y, z):
    """Returns the rotation that maps the coordinate axes to x, y and z, which must be orthonormal and right-handed."""
    trace = x[0] + y[1] + z[2]
    if trace > 0:
        s = 2 * math.sqrt(trace + 1)
        q = ((y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s, s / 4)
    elif x[0] > y[1] and x[0] > z[2]:
        s = 2 * math.sqrt(1 + x[0] - y[1] - z[2])
        q = (s / 4, (y[0] + x[1]) / s, (z[0] + x[2]) / s, (y[2] - z[1]) / s)
    elif y[1] > z[2]:
        s = 2 * math.sqrt(1 + y[1] - x[0] - z[2])
        q = ((y[0] + x[1]) / s, s / 4, (z[1] + y[2]) / s, (z[0] - x[2]) / s)
    else:
        s = 2 * math.sqrt(1 + z[2] - x[0] - y[1])
        q = ((z[0] + x[2]) / s, (z[1] + y[2]) / s, s / 4, (x[1] - y[0]) / s)
    n = math.sqrt(sum(c * c for c in q))
    return tuple(c / n for c in q)


def facing(direction, up=(0.0, 1.0, 0.0)):
    """Returns the rotation that turns +Z to `direction` and keeps +Y as close to `up` as possible."""
    z = normalize(direction)
    x = cross(up, z)
    if length(x) < 1e-6:
        x = cross((0.0, 0.0, -1.0), z)
    x = normalize(x)
    return from_basis(x, cross(z, x), z)
