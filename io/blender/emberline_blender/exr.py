"""Reads and writes EXR files with nothing but NumPy, since Blender's Python may have no other library.

Reads the files that `emberline render --exr-compression none` writes, which have one tiled part. Writes environment
maps.
"""
import struct

import numpy

_TYPES = {0: numpy.dtype("<u4"), 1: numpy.dtype("<f2"), 2: numpy.dtype("<f4")}


class ExrError(Exception):
    pass


def _attributes(data):
    at, found = 8, {}
    while data[at]:
        name_end = data.index(b"\0", at)
        kind_end = data.index(b"\0", name_end + 1)
        (size,) = struct.unpack_from("<i", data, kind_end + 1)
        value = kind_end + 5
        found[data[at:name_end].decode()] = data[value : value + size]
        at = value + size
    return found, at + 1


def _channels(listed):
    channels, at = [], 0
    while listed[at]:
        end = listed.index(b"\0", at)
        (kind,) = struct.unpack_from("<i", listed, end + 1)
        channels.append((listed[at:end].decode(), _TYPES[kind]))
        at = end + 17
    return channels


def read(path):
    """Returns the channels by name (float32, rows from the top) and the header's text attributes."""
    with open(path, "rb") as file:
        data = file.read()
    try:
        return _read(data)
    except (ValueError, IndexError, KeyError, struct.error) as error:
        raise ExrError(f"{path}: the add-on cannot read this EXR file: {error}") from error


def _read(data):
    magic, version = struct.unpack_from("<iI", data)
    if magic != 20000630 or version & 0xFF != 2 or not version & 0x200 or version & 0x1800:
        raise ValueError("expected a single tiled part")
    header, at = _attributes(data)
    if header["compression"] != b"\0":
        raise ValueError("expected no compression")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    tile_width, tile_height, _ = struct.unpack("<2IB", header["tiles"])
    channels = _channels(header["channels"])
    planes = {name: numpy.zeros((height, width), numpy.float32) for name, _ in channels}
    tiles = -(-width // tile_width) * -(-height // tile_height)
    for offset in struct.unpack_from(f"<{tiles}Q", data, at):
        column, row, _, _, _ = struct.unpack_from("<5i", data, offset)
        left, top = column * tile_width, row * tile_height
        w, h = min(tile_width, width - left), min(tile_height, height - top)
        line = sum(kind.itemsize for _, kind in channels) * w
        rows = numpy.frombuffer(data, numpy.uint8, line * h, offset + 20).reshape(h, line)
        start = 0
        for name, kind in channels:
            end = start + kind.itemsize * w
            planes[name][top : top + h, left : left + w] = numpy.ascontiguousarray(rows[:, start:end]).view(kind)
            start = end
    # The attributes' types are no longer known here, so every value that is valid UTF-8 counts as text.
    texts = {}
    for name, value in header.items():
        try:
            texts[name] = value.decode()
        except UnicodeDecodeError:
            pass
    return planes, texts


def write(path, rgb):
    """Writes float32 pixels (height x width x 3, rows from the top) as uncompressed scanlines."""
    rgb = numpy.asarray(rgb, "<f4")
    height, width, _ = rgb.shape

    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value

    listed = b"".join(c + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for c in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<iI", 20000630, 2)
    header += attribute(b"channels", b"chlist", listed)
    header += attribute(b"compression", b"compression", b"\0")
    header += attribute(b"dataWindow", b"box2i", window)
    header += attribute(b"displayWindow", b"box2i", window)
    header += attribute(b"lineOrder", b"lineOrder", b"\0")
    header += attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1.0))
    header += attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0.0, 0.0))
    header += attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1.0)) + b"\0"
    line = 8 + 12 * width
    first = len(header) + 8 * height
    with open(path, "wb") as file:
        file.write(header)
        file.write((first + line * numpy.arange(height, dtype="<u8")).tobytes())
        for y in range(height):
            file.write(struct.pack("<ii", y, 12 * width))
            file.write(rgb[y, :, ::-1].T.tobytes())
