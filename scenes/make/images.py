"""Encodes textures as PNG, and environments as Radiance RGBE. The encoded bytes are the same on every machine. Uses
only the standard library."""

import math
import struct
import zlib

from . import deflate


def _chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def _filtered(rows, bpp):
    """Filters each row with the PNG filter that minimises the sum of absolute residuals (PNG specification, 12.8). This
    also helps with palette images: our palettes are gradients, so neighbouring indices are close."""
    out = bytearray()
    above = bytes(len(rows[0]))
    for row in rows:
        left = bytes(bpp) + row[:-bpp]
        corner = bytes(bpp) + above[:-bpp]
        candidates = [
            row,
            bytes((x - a) & 255 for x, a in zip(row, left)),
            bytes((x - b) & 255 for x, b in zip(row, above)),
            bytes((x - ((a + b) >> 1)) & 255 for x, a, b in zip(row, left, above)),
            bytes((x - _paeth(a, b, c)) & 255 for x, a, b, c in zip(row, left, above, corner)),
        ]
        cost = [sum(v if v < 128 else 256 - v for v in c) for c in candidates]
        best = cost.index(min(cost))
        out.append(best)
        out += candidates[best]
        above = row
    return bytes(out)


def _paeth(a, b, c):
    p = a + b - c
    pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
    if pa <= pb and pa <= pc:
        return a
    return b if pb <= pc else c


def _png(width, height, kind, rows, extra=b""):
    bpp = {2: 3, 3: 1}[kind]
    header = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + extra
            + _chunk(b"IDAT", deflate.compress(_filtered(rows, bpp))) + _chunk(b"IEND", b""))


def png_rgb(rows):
    """Encodes `rows`, which are lists of (r, g, b) in 0..255. The values are stored as they are, so colours must be in
    sRGB, and data must be linear."""
    packed = [bytes(v for pixel in row for v in pixel) for row in rows]
    return _png(len(rows[0]), len(rows), 2, packed)


def png_palette(rows, palette):
    """Encodes `rows`, which are lists of indices into `palette`. The palette has at most 256 colours (r, g, b) in
    0..255."""
    plte = _chunk(b"PLTE", bytes(v for colour in palette for v in colour))
    return _png(len(rows[0]), len(rows), 3, [bytes(row) for row in rows], plte)


def png_gradient(field, stops, levels=64):
    """Maps a field of floats in [0, 1] to colours of a gradient, whose `stops` are (position, (r, g, b) in 0..255)."""
    palette = [_gradient(stops, i / (levels - 1)) for i in range(levels)]
    top = levels - 1
    rows = [[min(top, max(0, int(v * top + 0.5))) for v in row] for row in field]
    return png_palette(rows, palette)


def _gradient(stops, t):
    if t <= stops[0][0]:
        return stops[0][1]
    for (t0, c0), (t1, c1) in zip(stops, stops[1:]):
        if t <= t1:
            w = (t - t0) / (t1 - t0)
            return tuple(int(a + (b - a) * w + 0.5) for a, b in zip(c0, c1))
    return stops[-1][1]


def _rgbe(colour):
    top = max(colour)
    if top < 1e-32:
        return (0, 0, 0, 0)
    exponent = math.frexp(top)[1]
    scale = math.ldexp(256.0, -exponent)
    return tuple(min(255, int(c * scale)) for c in colour) + (exponent + 128,)


def _run_length(line):
    """Encodes one channel of a scanline in the new run-length format of RGBE, with runs of at least 4 bytes and at most
    128 literals at a time."""
    out = bytearray()
    i, n = 0, len(line)
    literal = bytearray()
    while i < n:
        run = 1
        while i + run < n and run < 127 and line[i + run] == line[i]:
            run += 1
        if run >= 4:
            while literal:
                out.append(min(128, len(literal)))
                out += literal[:128]
                del literal[:128]
            out += bytes((128 + run, line[i]))
        else:
            literal += line[i:i + run]
        i += run
    while literal:
        out.append(min(128, len(literal)))
        out += literal[:128]
        del literal[:128]
    return bytes(out)


def radiance_hdr(rows):
    """Encodes `rows`, which are lists of linear Rec. 709 (r, g, b). The top row is first."""
    width, height = len(rows[0]), len(rows)
    out = bytearray(b"#?RADIANCE\nSOFTWARE=emberline scenes/make_scenes.py\nFORMAT=32-bit_rle_rgbe\n\n")
    out += f"-Y {height} +X {width}\n".encode()
    for row in rows:
        pixels = [_rgbe(c) for c in row]
        out += bytes((2, 2, width >> 8, width & 255))
        for channel in range(4):
            out += _run_length(bytes(p[channel] for p in pixels))
    return bytes(out)
