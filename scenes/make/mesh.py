"""Triangle meshes. Every surface is a grid that maps (u, v) to points. With the directions du and dv in which u and v
increase, du x dv points outwards."""

import math

from .vec import add, cross, length, mul, normalize, rotate, sub


class Mesh:
    """A mesh has positions, normals, texture coordinates and counter-clockwise triangles. v increases downwards, as in
    glTF."""

    def __init__(self):
        self.positions = []
        self.normals = []
        self.uvs = []
        self.indices = []

    def grid(self, nu, nv, point):
        """Adds nu x nv cells. point(u, v), with u and v in [0, 1], must return (position, normal, uv). Skips triangles
        without area, which occur at the poles of a sphere."""
        base = len(self.positions)
        for j in range(nv + 1):
            for i in range(nu + 1):
                p, n, uv = point(i / nu, j / nv)
                self.positions.append(tuple(p))
                self.normals.append(normalize(n))
                self.uvs.append(tuple(uv))
        for j in range(nv):
            for i in range(nu):
                a = base + j * (nu + 1) + i
                b, c, d = a + 1, a + nu + 2, a + nu + 1
                for tri in ((a, b, c), (a, c, d)):
                    if self._has_area(tri):
                        self.indices.extend(tri)
        return self

    def _has_area(self, tri):
        a, b, c = (self.positions[t] for t in tri)
        e, f = sub(b, a), sub(c, a)
        longest = max(length(e), length(f), length(sub(c, b)))
        return length(cross(e, f)) > 1e-9 * longest * longest and longest > 0

    def append(self, other, translation=(0, 0, 0), rotation=(0, 0, 0, 1), scale=1.0):
        base = len(self.positions)
        self.positions += [add(rotate(rotation, mul(p, scale)), translation) for p in other.positions]
        self.normals += [rotate(rotation, n) for n in other.normals]
        self.uvs += other.uvs
        self.indices += [base + i for i in other.indices]
        return self

    def tangents(self):
        """Computes glTF tangents. A tangent points in the direction of increasing u. Its sign is such that
        sign * cross(normal, tangent) points in the direction of decreasing v, because in glTF v increases downwards and
        the y of a normal map points upwards. Triangles are weighted by their area."""
        sums = [(0.0, 0.0, 0.0)] * len(self.positions)
        signs = [0.0] * len(self.positions)
        for t in range(0, len(self.indices), 3):
            tri = self.indices[t:t + 3]
            a, b, c = (self.positions[k] for k in tri)
            (ua, va), (ub, vb), (uc, vc) = (self.uvs[k] for k in tri)
            e, f = sub(b, a), sub(c, a)
            du1, dv1, du2, dv2 = ub - ua, vb - va, uc - ua, vc - va
            area = du1 * dv2 - du2 * dv1
            tangent = sub(mul(e, dv2), mul(f, dv1))
            if area < 0:
                tangent = mul(tangent, -1)
            size = length(cross(e, f)) / (length(tangent) or 1.0)
            for k in tri:
                sums[k] = add(sums[k], mul(tangent, size))
                signs[k] -= area
        out = []
        for n, t, s in zip(self.normals, sums, signs):
            t = sub(t, mul(n, sum(a * b for a, b in zip(n, t))))
            if length(t) < 1e-9:
                t = cross(n, (0, 1, 0) if abs(n[1]) < 0.9 else (1, 0, 0))
            out.append(normalize(t) + (1.0 if s >= 0 else -1.0,))
        return out

    def scaled_uv(self, su, sv):
        self.uvs = [(u * su, v * sv) for u, v in self.uvs]
        return self


def quad(width, height, uv_scale=(1.0, 1.0), cells=1):
    """A rectangle in the xy plane, facing +Z."""
    return Mesh().grid(cells, cells, lambda u, v: (((u - 0.5) * width, (v - 0.5) * height, 0), (0, 0, 1),
                                                   (u * uv_scale[0], (1 - v) * uv_scale[1])))


def floor(width, depth, uv_per_unit=1.0, cells=1):
    """A rectangle in the xz plane, facing +Y. The texture coordinates are the world units times `uv_per_unit`."""
    return Mesh().grid(cells, cells, lambda u, v: (((u - 0.5) * width, 0, (0.5 - v) * depth), (0, 1, 0),
                                                   (u * width * uv_per_unit, (1 - v) * depth * uv_per_unit)))


def disc(radius, segments=96, rings=1):
    """A disc in the xz plane, facing +Y."""
    def point(u, v):
        a, r = 2 * math.pi * u, radius * (1 - v)
        x, z = r * math.cos(a), -r * math.sin(a)
        return (x, 0, z), (0, 1, 0), (0.5 + x / (2 * radius), 0.5 + z / (2 * radius))
    return Mesh().grid(segments, rings, point)


def sphere(radius=1.0, segments=64, rings=32):
    def point(u, v):
        a, b = 2 * math.pi * u, math.pi * (v - 0.5)
        r, y = (0.0 if v in (0.0, 1.0) else math.cos(b)), math.sin(b)
        n = (r * math.cos(a), y, -r * math.sin(a))
        return mul(n, radius), n, (u, 1 - v)
    return Mesh().grid(segments, rings, point)


def torus(major, minor, segments=64, sides=24):
    """A torus around the y axis."""
    def point(u, v):
        a, b = 2 * math.pi * u, 2 * math.pi * v
        n = (math.cos(b) * math.cos(a), math.sin(b), -math.cos(b) * math.sin(a))
        c = (major * math.cos(a), 0, -major * math.sin(a))
        return add(c, mul(n, minor)), n, (u, 1 - v)
    return Mesh().grid(segments, sides, point)


def lathe(sections, segments=64, uv_scale=(1.0, 1.0)):
    """Rotates a profile around the y axis. `sections` are polylines of (radius, height). Normals are smooth within a
    section, and there are creases between sections. The outside is to the right of the profile's direction. So a
    profile starts at the bottom of the axis and goes up the outside. The profile of a vessel then comes down the
    inside."""
    mesh = Mesh()
    total = sum(math.dist(a, b) for s in sections for a, b in zip(s, s[1:]))
    run = 0.0
    for section in sections:
        marks = [run]
        for a, b in zip(section, section[1:]):
            run += math.dist(a, b)
            marks.append(run)
        normals = [_profile_normal(section, k) for k in range(len(section))]

        def point(u, v, section=section, marks=marks, normals=normals):
            k = round(v * (len(section) - 1))
            (r, y), (nr, ny) = section[k], normals[k]
            a = 2 * math.pi * u
            c, s = math.cos(a), -math.sin(a)
            return (r * c, y, r * s), (nr * c, ny, nr * s), (u * uv_scale[0], (1 - marks[k] / total) * uv_scale[1])
        mesh.grid(segments, len(section) - 1, point)
    return mesh


def _profile_normal(section, k):
    r, y = section[k]
    a, b = section[max(k - 1, 0)], section[min(k + 1, len(section) - 1)]
    if r == 0:  # on the axis, the surface is horizontal
        return (0.0, -1.0 if b[0] > a[0] else 1.0)
    if 0 < k < len(section) - 1:  # the tangent of a parabola through three points, which is accurate for uneven steps
        la, lb = math.dist(a, (r, y)), math.dist((r, y), b)
        tr = (r - a[0]) / la * lb + (b[0] - r) / lb * la
        ty = (y - a[1]) / la * lb + (b[1] - y) / lb * la
    else:
        tr, ty = b[0] - a[0], b[1] - a[1]
    n = math.hypot(tr, ty)
    return (ty / n, -tr / n)


def smooth(points, steps=6):
    """A Catmull-Rom spline through the points, with `steps` segments between two points. The end points are doubled."""
    p = [points[0]] + list(points) + [points[-1]]
    out = []
    for i in range(1, len(p) - 2):
        for k in range(steps):
            t = k / steps
            out.append(tuple(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t
                                    + (3 * b - a - 3 * c + d) * t ** 3)
                             for a, b, c, d in zip(p[i - 1], p[i], p[i + 1], p[i + 2])))
    return out + [tuple(points[-1])]


def arc(centre, radius, start, end, steps=8):
    """Returns points of a profile (radius, height) on a circle. Angles are in degrees from +radius towards +height."""
    return [(centre[0] + radius * math.cos(math.radians(start + (end - start) * k / steps)),
             centre[1] + radius * math.sin(math.radians(start + (end - start) * k / steps))) for k in range(steps + 1)]


def rounded_box(width, height, depth, radius, steps=3, uv_per_unit=1.0):
    """A box with rounded edges, centred at the origin. Each face has its own texture coordinates, which are the world
    units times `uv_per_unit`."""
    half = (width / 2, height / 2, depth / 2)
    inner = tuple(h - radius for h in half)
    angles = [math.tan(math.pi / 4 * k / steps) for k in range(steps + 1)]
    mesh = Mesh()
    for axis in range(3):
        for sign in (1, -1):
            a, b = (axis + 1) % 3, (axis + 2) % 3
            if sign < 0:
                a, b = b, a
            lines = [[-inner[x] - radius * t for t in reversed(angles)] + [inner[x] + radius * t for t in angles]
                     for x in (a, b)]
            # Textures must be upright on the sides, so their horizontal axis is the axis that is not y.
            ua, va = {0: (2, 1), 1: (0, 2), 2: (0, 1)}[axis]

            def point(u, v, axis=axis, sign=sign, a=a, b=b, lines=lines, ua=ua, va=va):
                p = [0.0, 0.0, 0.0]
                p[a] = lines[0][round(u * (len(lines[0]) - 1))]
                p[b] = lines[1][round(v * (len(lines[1]) - 1))]
                p[axis] = sign * half[axis]
                core = tuple(max(-i, min(i, c)) for c, i in zip(p, inner))
                n = normalize(sub(p, core))
                q = add(core, mul(n, radius))
                tv = q[va] + half[va] if va == 2 else half[va] - q[va]
                return q, n, ((q[ua] + half[ua]) * uv_per_unit, tv * uv_per_unit)
            mesh.grid(len(lines[0]) - 1, len(lines[1]) - 1, point)
    return mesh


def cylinder(radius, height, segments=48, bevel=0.0, steps=3):
    """A closed cylinder that stands on the plane y = 0. `bevel` is the radius of its rounded rims."""
    if bevel <= 0:
        sections = [[(0, 0), (radius, 0)], [(radius, 0), (radius, height)], [(radius, height), (0, height)]]
    else:
        r = radius - bevel
        sections = [[(0, 0), (r, 0)], arc((r, bevel), bevel, -90, 0, steps),
                    [(radius, bevel), (radius, height - bevel)], arc((r, height - bevel), bevel, 0, 90, steps),
                    [(r, height), (0, height)]]
    return lathe(sections, segments)


def tube(path, radius, sides=12, closed=False, caps=True):
    """A round wire along `path`. Projects the frame from each point to the next, which is good enough for our gentle
    turns. Double reflection would be better for sharp turns."""
    n = len(path)
    tangents = []
    for k in range(n):
        a = path[k - 1] if k or closed else path[0]
        b = path[(k + 1) % n] if k + 1 < n or closed else path[-1]
        tangents.append(normalize(sub(b, a)))
    side = cross(tangents[0], (0, 1, 0) if abs(tangents[0][1]) < 0.9 else (1, 0, 0))
    frames = []
    for t in tangents:
        up = normalize(cross(side, t))
        side = cross(t, up)
        frames.append((side, up))
    count = n if closed else n - 1

    def point(u, v):
        k = round(v * count) % n
        s, up = frames[k]
        a = 2 * math.pi * u
        normal = add(mul(s, math.cos(a)), mul(up, -math.sin(a)))
        return add(path[k], mul(normal, radius)), normal, (u, 1 - v)
    mesh = Mesh().grid(sides, count, point)
    if caps and not closed:
        for end, sign in ((0, -1), (n - 1, 1)):
            s, up = frames[end]
            normal = mul(tangents[end], sign)

            def cap(u, v, s=s, up=up, normal=normal, centre=path[end], sign=sign):
                a = 2 * math.pi * u * sign
                offset = add(mul(s, math.cos(a)), mul(up, -math.sin(a)))
                return add(centre, mul(offset, radius * (1 - v))), normal, (u, v)
            mesh.grid(sides, 1, cap)
    return mesh


def sweep_wall(width, depth, height, radius, uv_per_unit=1.0, steps=16):
    """A studio cyclorama: a floor that reaches towards +Z, a round corner at the back, and a wall at z = -depth / 2. It
    is single-sided and faces the front."""
    back = -depth / 2
    path = [(0.0, depth / 2), (0.0, back + radius)]
    normals = [(1.0, 0.0), (1.0, 0.0)]
    for k in range(1, steps + 1):
        a = math.pi / 2 * k / steps
        path.append((radius - radius * math.cos(a), back + radius - radius * math.sin(a)))
        normals.append((math.cos(a), math.sin(a)))
    path.append((height, back))
    normals.append((0.0, 1.0))
    marks = [0.0]
    for a, b in zip(path, path[1:]):
        marks.append(marks[-1] + math.dist(a, b))

    def point(u, v):
        k = round(v * (len(path) - 1))
        y, z = path[k]
        ny, nz = normals[k]
        return ((u - 0.5) * width, y, z), (0, ny, nz), (u * width * uv_per_unit, -marks[k] * uv_per_unit)
    return Mesh().grid(1, len(path) - 1, point)
