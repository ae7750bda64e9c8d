"""Periodic value noise. A field is a list of rows of floats. A field of size n repeats with period n."""

import random


def constant_free(rows):
    """Returns the field, scaled and shifted so that its values range from 0 to 1."""
    low, high = min(map(min, rows)), max(map(max, rows))
    return [[(v - low) / (high - low) for v in row] for row in rows]


def _ease(t):
    return t * t * t * (t * (t * 6 - 15) + 10)


def _octave(width, height, fx, fy, source):
    lattice = [[source.random() for _ in range(fx)] for _ in range(fy)]
    columns = []
    for x in range(width):
        p = x * fx / width
        i = int(p)
        columns.append((i, (i + 1) % fx, _ease(p - i)))
    rows = []
    for y in range(height):
        p = y * fy / height
        j = int(p)
        t = _ease(p - j)
        line = [a + (b - a) * t for a, b in zip(lattice[j], lattice[(j + 1) % fy])]
        rows.append([line[a] + (line[b] - line[a]) * w for a, b, w in columns])
    return rows


def fractal(width, height, fx, fy, octaves, seed, gain=0.5):
    """Sums octaves of value noise and stretches the result to [0, 1]. The first octave has fx x fy lattice cells."""
    source = random.Random(seed)
    total = [[0.0] * width for _ in range(height)]
    weight = 1.0
    for _ in range(octaves):
        if fx > width or fy > height:
            break
        layer = _octave(width, height, fx, fy, source)
        total = [[t + weight * v for t, v in zip(a, b)] for a, b in zip(total, layer)]
        weight *= gain
        fx, fy = fx * 2, fy * 2
    return constant_free(total)


def sample(rows, x, y):
    """Interpolates a field bilinearly and periodically. x and y are in texels."""
    height, width = len(rows), len(rows[0])
    i, j = int(x // 1), int(y // 1)
    s, t = x - i, y - j
    a, b = rows[j % height], rows[(j + 1) % height]
    i, k = i % width, (i + 1) % width
    top = a[i] + (a[k] - a[i]) * s
    return top + (b[i] + (b[k] - b[i]) * s - top) * t


def warped(rows, dx, dy, amount):
    """Resamples the field `rows`. The fields `dx` and `dy` displace each position by at most `amount` texels."""
    return [[sample(rows, x + (dx[y][x] - 0.5) * 2 * amount, y + (dy[y][x] - 0.5) * 2 * amount)
             for x in range(len(rows[0]))] for y in range(len(rows))]
