"""Makes the textures of the scenes. Each is a PNG that tiles. Colours are sRGB bytes, as stored in the file."""

import math
import random

from . import images, noise


def _hex(code):
    return tuple(int(code[i:i + 2], 16) for i in (1, 3, 5))


def _stops(*pairs):
    return [(t, _hex(c)) for t, c in pairs]


WALNUT = _stops((0, "#2a1810"), (0.35, "#4a2c1a"), (0.7, "#6e4527"), (1, "#8a5c36"))
OAK = _stops((0, "#6b4526"), (0.3, "#9a6b3f"), (0.7, "#bd8f5d"), (1, "#d2aa79"))
MARBLE = _stops((0, "#4d5055"), (0.1, "#8b8c8c"), (0.28, "#cfccc5"), (0.55, "#e6e2da"), (1, "#f2efe8"))
DARK_MARBLE = _stops((0, "#e9dcc4"), (0.06, "#a98d62"), (0.16, "#3a3d40"), (0.5, "#17191c"), (1, "#0d0f11"))


def wood(stops, size=512, planks=4, seed=1, seams=True, levels=56):
    """Boards along u. They have slanted rings and fine pores, and each board has a different tone."""
    warp = noise.fractal(size, size, 2, 4 * planks, 3, seed)
    streaks = noise.fractal(size, size, 4, size // 4, 2, seed + 1, 0.7)
    pores = noise.fractal(size, size, size // 16, size, 1, seed + 2)
    tone = [((k * 7 + seed * 3) % 5) / 4 for k in range(planks)]
    field = []
    for y in range(size):
        v = y * planks / size
        k = int(v)
        f = v - k
        groove = 0.0
        if seams:
            edge = min(f, 1 - f) * size / planks
            groove = max(0.0, 1.0 - edge / 1.5)
        row = []
        for x in range(size):
            rings = 2.2 * f * f + 0.35 * f + 1.15 * warp[y][x] + 0.13 * k
            phase = rings * 7 % 1.0
            ring = phase if phase < 0.8 else (1 - phase) * 4  # darkens slowly, then brightens quickly, as in a tree
            value = 0.62 - 0.34 * ring + 0.30 * (streaks[y][x] - 0.5) + 0.22 * (tone[k] - 0.5)
            if pores[y][x] > 0.86:
                value -= 0.16
            row.append(value * (1 - 0.85 * groove))
        field.append(row)
    return images.png_gradient(field, stops, levels)


def marble_field(size, seed, veins=0.9):
    base = noise.fractal(size, size, 3, 3, 5, seed, 0.55)
    dx = noise.fractal(size, size, 2, 2, 4, seed + 1)
    dy = noise.fractal(size, size, 2, 2, 4, seed + 2)
    ridged = [[abs(2 * v - 1) for v in row] for row in noise.warped(base, dx, dy, size * 0.22)]
    cloud = noise.fractal(size, size, 4, 4, 3, seed + 3)
    return [[min(1.0, r ** 0.5 * veins + 0.25 * c - 0.04) for r, c in zip(a, b)] for a, b in zip(ridged, cloud)]


def marble(stops=None, size=512, seed=7, veins=0.9, levels=48):
    return images.png_gradient(marble_field(size, seed, veins), stops or MARBLE, levels)


def checker(a, b, size=16):
    """A checkerboard of 2 x 2 squares."""
    return images.png_palette([[(2 * x // size + 2 * y // size) % 2 for x in range(size)] for y in range(size)],
                              [_hex(a), _hex(b)])


def stripes(colours, size=512):
    """Vertical stripes of equal width. Their edges are blended over three texels."""
    n = len(colours)
    palette, row = [], []
    for x in range(size):
        p = x * n / size
        k = int(p)
        w = min(1.0, max(0.0, (p - k) * size / n / 3))
        colour = tuple(int(a + (b - a) * w + 0.5) for a, b in zip(_hex(colours[k - 1]), _hex(colours[k])))
        if colour not in palette:
            palette.append(colour)
        row.append(palette.index(colour))
    return images.png_palette([row] * 8, palette)


def planet(size=512, seed=23):
    """The bands of a gas giant, as a texture for a sphere. The texture is twice as wide as high."""
    width, height = size, size // 2
    dx = noise.fractal(width, height, 4, 4, 4, seed)
    bands = noise.fractal(width, height, 1, 16, 2, seed + 1, 0.6)
    fine = noise.fractal(width, height, 2, 64, 2, seed + 2)
    field = []
    for y in range(height):
        row = []
        for x in range(width):
            w = y + (dx[y][x] - 0.5) * 34
            row.append(0.8 * noise.sample(bands, x, w) + 0.2 * noise.sample(fine, x, w))
        field.append(row)
    return images.png_gradient(noise.constant_free(field), _stops(
        (0, "#5b2a1d"), (0.25, "#a8532f"), (0.45, "#d99a63"), (0.6, "#efd2a4"), (0.8, "#c7724a"), (1, "#f3e3c6")), 48)


def terrazzo(ground, chips, size=512, count=420, seed=5):
    """Stone chips in a plain ground. The chips are small convex polygons that wrap around the edges of the texture."""
    source = random.Random(seed)
    rows = [[0] * size for _ in range(size)]
    for _ in range(count):
        cx, cy = source.random() * size, source.random() * size
        radius = size * (0.006 + 0.022 * source.random() ** 2)
        sides = [(math.cos(a), math.sin(a), radius * (0.55 + 0.45 * source.random()))
                 for a in (source.random() * 6.28318 for _ in range(6))]
        colour = 1 + int(source.random() * len(chips))
        reach = int(radius * 1.6) + 1
        for y in range(int(cy) - reach, int(cy) + reach + 1):
            for x in range(int(cx) - reach, int(cx) + reach + 1):
                ox, oy = x - cx, y - cy
                if ox * ox + oy * oy < reach * reach and all(ox * a + oy * b < d for a, b, d in sides):
                    rows[y % size][x % size] = colour
    return images.png_palette(rows, [_hex(ground)] + [_hex(c) for c in chips])


def normal_map(height_field, strength, levels=32):
    """Returns the tangent-space normals of a periodic height field. As in glTF, +Y points up in the image."""
    size_y, size_x = len(height_field), len(height_field[0])
    rows = []
    for y in range(size_y):
        above, below, here = height_field[y - 1], height_field[(y + 1) % size_y], height_field[y]
        row = []
        for x in range(size_x):
            dx = (here[(x + 1) % size_x] - here[x - 1]) * strength
            dy = (above[x] - below[x]) * strength
            n = math.sqrt(dx * dx + dy * dy + 1)
            row.append(tuple(_coarse(c / n, levels) for c in (-dx, -dy, 1)))
        rows.append(row)
    return images.png_rgb(rows)


def _coarse(c, levels):
    """Rounds a number in [-1, 1] to `levels` steps on each side of 0, and converts it to a byte, where 128 stands for
    0. Fewer steps compress better."""
    return min(255, max(0, 128 + int(round(c * levels)) * 127 // levels))


def hammered(size=256, count=150, seed=3, strength=9.0):
    """Overlapping shallow dents, as on beaten copper."""
    source = random.Random(seed)
    field = [[1.0] * size for _ in range(size)]
    # The dents lie on a jittered grid, so that they cover the whole texture without clumps.
    n = int(math.sqrt(count))
    cell = size / n
    for j in range(n):
        for i in range(n):
            cx = (i + 0.15 + 0.7 * source.random() + (0.5 if j % 2 else 0)) * cell
            cy = (j + 0.15 + 0.7 * source.random()) * cell
            radius = cell * (0.85 + 0.3 * source.random())
            reach = int(radius) + 1
            for y in range(int(cy) - reach, int(cy) + reach + 1):
                for x in range(int(cx) - reach, int(cx) + reach + 1):
                    d = ((x - cx) ** 2 + (y - cy) ** 2) / (radius * radius)
                    if d < 1:
                        a, b = y % size, x % size
                        field[a][b] = min(field[a][b], d)
    return normal_map(field, strength / 10, 48)


def plaster(size=256, seed=11, strength=2.5):
    """The slight unevenness of a painted wall."""
    return normal_map(noise.fractal(size, size, 6, 6, 4, seed, 0.45), strength, 40)


def brushed(size=256, seed=17):
    """The roughness of metal that is brushed along u. As in glTF, green is the roughness and blue is metallic."""
    field = noise.fractal(size, size, 2, size // 2, 2, seed, 0.8)
    palette = [(255, int(120 + 135 * k / 31), 255) for k in range(32)]
    return images.png_palette([[int(v * 31 + 0.5) for v in row] for row in field], palette)


def window(size=128, bars=(2, 3)):
    """Daylight seen through a sash window with dark glazing bars. The light is bright above, and dimmer and warmer
    below."""
    palette = [(0, 0, 0)]
    for k in range(64):
        t = k / 63
        palette.append((int(255 - 52 * t), int(250 - 70 * t), int(244 - 98 * t)))
    rows = []
    for y in range(size):
        row = []
        for x in range(size):
            fx, fy = x * bars[0] / size % 1, y * bars[1] / size % 1
            bar = min(fx, 1 - fx) * size / bars[0] < 3 or min(fy, 1 - fy) * size / bars[1] < 2
            row.append(0 if bar else 1 + 63 * y // size)
        rows.append(row)
    return images.png_palette(rows, palette)


def soft_edge(size=64, edge=0.18):
    """A diffuser, which is uniformly bright in the middle and fades towards the edges."""
    def ramp(t):
        t = min(1.0, min(t, 1 - t) / edge)
        return t * t * (3 - 2 * t)
    field = [[ramp((x + 0.5) / size) * ramp((y + 0.5) / size) for x in range(size)] for y in range(size)]
    return images.png_gradient(field, _stops((0, "#202020"), (1, "#ffffff")), 64)
