"""Makes the two environment maps. A direction is at u = 0.5 + atan2(z, x) / 2 pi: the image's centre shows +X, u = 0.25
shows -Z, and the top row shows +Y. The scenes' cameras are at +Z and look towards -Z."""

import math

from . import images, noise

WIDTH, HEIGHT = 1024, 512


def _directions():
    """Yields rows of directions (x, y, z), one per texel centre."""
    azimuths = [(2 * (i + 0.5) / WIDTH - 1) * math.pi for i in range(WIDTH)]
    cosines = [(math.cos(a), math.sin(a)) for a in azimuths]
    for j in range(HEIGHT):
        elevation = (0.5 - (j + 0.5) / HEIGHT) * math.pi
        y, r = math.sin(elevation), math.cos(elevation)
        yield [(r * c, y, r * s) for c, s in cosines]


def _step(edge, width, x):
    t = min(1.0, max(0.0, (x - edge) / width + 0.5))
    return t * t * (3 - 2 * t)


def _axes(azimuth, elevation):
    """Returns the centre, right and up vectors of a panel. The azimuth is measured in degrees from -Z, which is behind
    the subject, towards +X."""
    a, e = math.radians(azimuth), math.radians(elevation)
    centre = (math.cos(e) * math.sin(a), math.sin(e), -math.cos(e) * math.cos(a))
    right = (math.cos(a), 0.0, math.sin(a))
    up = (-math.sin(e) * math.sin(a), math.cos(e), math.sin(e) * math.cos(a))
    return centre, right, up


# Each panel has an azimuth and an elevation in degrees, a half width and a half height as tangents, the softness of its
# edge, and its radiance.
_PANELS = [
    (-122, 38, 0.62, 0.46, 0.16, (10.5, 8.6, 6.4)),   # key: a large warm box, in front on the left
    (104, 20, 0.16, 0.62, 0.10, (4.2, 5.8, 8.0)),     # rim: a tall cool strip, right
    (-64, 16, 0.07, 0.55, 0.05, (3.4, 4.0, 4.8)),     # a thin strip, behind on the left
    (20, 78, 0.75, 0.22, 0.12, (5.6, 5.5, 5.3)),      # overhead bank
    (150, 30, 0.30, 0.30, 0.20, (1.6, 1.5, 1.5)),     # weak fill, in front on the right
    (-150, 62, 0.030, 0.030, 0.015, (60, 52, 42)),    # a small bare lamp, for glints
]


def studio():
    """A photo studio: soft boxes, a lit backdrop, a warm and a cool side, and light reflected from the floor."""
    panels = [_axes(p[0], p[1]) + p[2:] for p in _PANELS]
    rows = []
    for line in _directions():
        row = []
        for x, y, z in line:
            if y >= 0:
                t = math.sqrt(y)
                r, g, b = 0.17 - 0.11 * t, 0.175 - 0.11 * t, 0.19 - 0.11 * t
            else:
                t = math.sqrt(-y)
                r, g, b = 0.17 - 0.08 * t, 0.175 - 0.095 * t, 0.19 - 0.12 * t
            warm = 0.5 - 0.5 * x  # 1 on the left and 0 on the right
            r, g, b = r * (0.8 + 0.35 * warm), g * (0.9 + 0.1 * warm), b * (1.12 - 0.3 * warm)
            if z < 0:  # the backdrop, with a pool of light behind the subject
                pool = math.exp(-(x * x * 5.0 + (y - 0.04) ** 2 * 14.0)) * z * z
                r, g, b = r + 0.30 * pool, g + 0.34 * pool, b + 0.39 * pool
            for centre, right, up, half_w, half_h, soft, colour in panels:
                d = x * centre[0] + y * centre[1] + z * centre[2]
                if d <= 0.05:
                    continue
                a = abs(x * right[0] + y * right[1] + z * right[2]) / d
                e = abs(x * up[0] + y * up[1] + z * up[2]) / d
                if a > half_w + soft or e > half_h + soft:
                    continue
                w = _step(-half_w, soft, -a) * _step(-half_h, soft, -e)
                hot = w * (1.0 - 0.35 * (a / half_w) ** 2 - 0.25 * (e / half_h) ** 2) if w > 0 else 0.0
                hot = max(0.0, hot)
                r, g, b = r + colour[0] * hot, g + colour[1] * hot, b + colour[2] * hot
            row.append((r, g, b))
        rows.append(row)
    return images.radiance_hdr(rows)


SUN_AZIMUTH, SUN_ELEVATION, SUN_RADIUS = -38.0, 9.0, 0.9  # in degrees; the azimuth is measured from -Z towards +X


def dusk():
    """A low sun behind the subject on the left, a clear sky from orange to blue, and thin bands of cloud."""
    sun, _, _ = _axes(SUN_AZIMUTH, SUN_ELEVATION)
    clouds = noise.fractal(256, 256, 3, 10, 5, 41, 0.55)
    edge = math.cos(math.radians(SUN_RADIUS))
    rows = []
    for line in _directions():
        row = []
        for x, y, z in line:
            d = max(-1.0, min(1.0, x * sun[0] + y * sun[1] + z * sun[2]))
            level = math.hypot(x, z)
            towards = 0.5 + 0.5 * (x * sun[0] + z * sun[2]) / (level * math.hypot(sun[0], sun[2]) + 1e-9)
            h = max(0.0, y)
            low = math.exp(-h * 9.0)
            mid = math.exp(-h * 4.2) - low * 0.6
            near = towards * towards
            r = 0.028 + mid * (0.110 + 0.26 * near) + low * (0.12 + 0.62 * near)
            g = 0.058 + mid * (0.150 + 0.11 * near) + low * (0.09 + 0.21 * near)
            b = 0.130 + mid * (0.230 - 0.05 * near) + low * (0.10 - 0.01 * near)
            glow = math.exp((d - 1) * 26.0)
            r, g, b = r + 1.0 * glow, g + 0.46 * glow, b + 0.14 * glow
            if y > 0.012:
                # The clouds form a flat layer, so distant clouds crowd towards the horizon. The clouds fade out near
                # the horizon and overhead.
                s = 46.0 / (y + 0.10)
                c = noise.sample(clouds, x * s + 90.0, z * s * 1.6 + 31.0)
                c = _step(0.60, 0.34, c) * _step(0.05, 0.09, y) * (1 - _step(0.62, 0.5, y))
                lit = 0.16 + 0.74 * near * near * math.exp(-h * 2.0)
                r, g, b = (v + (w - v) * 0.72 * c for v, w in
                           zip((r, g, b), (0.05 + 1.05 * lit, 0.07 + 0.50 * lit, 0.12 + 0.30 * lit)))
            if y < 0:  # haze fades into the ground below the horizon
                t = min(1.0, -y * 14.0)
                r, g, b = (v + (w - v) * t for v, w in zip((r, g, b), (0.06, 0.055, 0.055)))
            # Draw the sun's disc, with scattered light around it that hides the jagged edge of the disc.
            if d > edge:
                r, g, b = r + 14000.0, g + 7400.0, b + 2900.0
            elif d > 0.98:
                halo = 20 * math.exp((math.radians(SUN_RADIUS) - math.acos(d)) / math.radians(0.45))
                r, g, b = r + halo, g + 0.66 * halo, b + 0.30 * halo
            row.append((r, g, b))
        rows.append(row)
    return images.radiance_hdr(rows)
