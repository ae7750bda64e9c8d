#!/usr/bin/env python3
"""Writes .glb scenes that are large enough to measure loading. Writes them row by row, which takes little memory.

  mesh OUT --triangles N                    one wavy sheet with normals and texture coordinates
  instances OUT --triangles N --count M     M instances of such a sheet: --nodes gives each a node,
                                            otherwise EXT_mesh_gpu_instancing is used
  textures OUT --maps N --size S            N panels in a wall, each with an S x S RGBA map
"""

import argparse
import array
import json
import math
import struct
import zlib


def pad(size, to=4):
    return -size % to


class Glb:
    """Collects writers of binary data; save() writes the JSON and then streams the data."""

    def __init__(self):
        self.views, self.accessors, self.parts, self.size = [], [], [], 0

    def view(self, size, write):
        self.views.append({"buffer": 0, "byteOffset": self.size, "byteLength": size})
        self.parts.append((size, write))
        self.size += size + pad(size)
        return len(self.views) - 1

    def accessor(self, code, kind, count, components, write, **bounds):
        self.accessors.append({"bufferView": self.view(count * components * 4, write),
                               "componentType": code, "type": kind, "count": count, **bounds})
        return len(self.accessors) - 1

    def save(self, path, document):
        document = {"asset": {"version": "2.0", "generator": "large_scene.py"}, "scene": 0,
                    **document, "buffers": [{"byteLength": self.size}], "bufferViews": self.views,
                    "accessors": self.accessors}
        text = json.dumps(document).encode()
        text += b" " * pad(len(text))
        with open(path, "wb") as out:
            out.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + self.size))
            out.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
            out.write(struct.pack("<II", self.size, 0x004E4942))
            for size, write in self.parts:
                start = out.tell()
                for piece in write():
                    out.write(piece)
                assert out.tell() - start == size
                out.write(b"\0" * pad(size))


def sheet(glb, triangles, side=2.0):
    """Returns attributes and indices of a wavy square of about `triangles` triangles."""
    n = max(1, round(math.sqrt(triangles / 2)))
    step, waves, height = side / n, 40.0 / side, side / 100
    xs = [i * step - side / 2 for i in range(n + 1)]
    sines = [math.sin(waves * x) for x in xs]
    slopes = [-height * waves * math.cos(waves * x) for x in xs]

    def rows(make):
        return lambda: (array.array("f", [v for i in range(n + 1) for v in make(i, j)]).tobytes()
                        for j in range(n + 1))

    def normal(i, j):
        x, z = slopes[i] * sines[j], slopes[j] * sines[i]
        length = math.sqrt(x * x + 1 + z * z)
        return x / length, 1 / length, z / length

    def indices():
        first = [v for i in range(n) for v in (i, i + n + 1, i + 1, i + 1, i + n + 1, i + n + 2)]
        for j in range(n):
            yield array.array("I", [v + j * (n + 1) for v in first]).tobytes()

    count, half = (n + 1) ** 2, side / 2
    place = rows(lambda i, j: (xs[i], height * sines[i] * sines[j], xs[j]))
    attributes = {
        "POSITION": glb.accessor(5126, "VEC3", count, 3, place, min=[-half, -height, -half],
                                 max=[half, height, half]),
        "NORMAL": glb.accessor(5126, "VEC3", count, 3, rows(normal)),
        "TEXCOORD_0": glb.accessor(5126, "VEC2", count, 2, rows(lambda i, j: (i / n, j / n)))}
    return {"attributes": attributes, "indices": glb.accessor(5125, "SCALAR", 6 * n * n, 1, indices)}


def mesh(options):
    glb = Glb()
    primitive = sheet(glb, options.triangles)
    glb.save(options.out, {"scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                           "meshes": [{"primitives": [primitive]}]})


def instances(options):
    glb = Glb()
    primitive = sheet(glb, options.triangles)
    across = math.ceil(math.sqrt(options.count))
    places = [(2.2 * (i % across), 0.0, 2.2 * (i // across)) for i in range(options.count)]
    if options.nodes:
        nodes = [{"mesh": 0, "translation": place} for place in places]
    else:
        def write():
            yield array.array("f", [v for place in places for v in place]).tobytes()
        moved = glb.accessor(5126, "VEC3", options.count, 3, write)
        nodes = [{"mesh": 0, "extensions": {
            "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moved}}}}]
    glb.save(options.out, {"scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
                           "meshes": [{"primitives": [primitive]}],
                           "extensionsUsed": ["EXT_mesh_gpu_instancing"]})


def png(size, seed):
    """Returns a picture with bricks of many sizes and colours, so that every level of detail has content."""
    def row(y):
        out = bytearray()
        for x in range(0, size, 8):
            value = (x // 64 * 37 + y // 64 * 101 + seed * 59) & 255
            fine = 90 * ((x // 8 + y // 8) & 1)
            texel = bytes((max(value - fine, 20), (value * 3 + seed) & 255, 200 - fine, 255))
            out += texel * 8
        return b"\0" + bytes(out)

    def chunk(name, data):
        return (struct.pack(">I", len(data)) + name + data
                + struct.pack(">I", zlib.crc32(name + data)))

    packer = zlib.compressobj(1)
    # Eight consecutive rows are equal.
    data = b"".join([packer.compress(row(y) * 8) for y in range(0, size, 8)] + [packer.flush()])
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 6, 0, 0, 0))
            + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def textures(options):
    glb = Glb()
    primitive = sheet(glb, 2)
    across = math.ceil(math.sqrt(options.maps))
    pictures = [png(options.size, i) for i in range(options.maps)]
    views = [glb.view(len(p), lambda p=p: [p]) for p in pictures]
    turn = [math.sqrt(0.5), 0, 0, math.sqrt(0.5)]  # upright, facing +z
    nodes = [{"mesh": i, "rotation": turn,
              "translation": [2.1 * (i % across), 2.1 * (i // across), 0]}
             for i in range(options.maps)]
    glb.save(options.out, {
        "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
        "meshes": [{"primitives": [{**primitive, "material": i}]} for i in range(options.maps)],
        "materials": [{"doubleSided": True, "pbrMetallicRoughness": {
            "baseColorTexture": {"index": i}, "metallicFactor": 0}} for i in range(options.maps)],
        "textures": [{"source": i} for i in range(options.maps)],
        "images": [{"bufferView": v, "mimeType": "image/png"} for v in views]})


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=("mesh", "instances", "textures"))
    parser.add_argument("out")
    parser.add_argument("--triangles", type=int, default=10_000_000, help="triangles of a mesh")
    parser.add_argument("--count", type=int, default=1000, help="number of instances")
    parser.add_argument("--nodes", action="store_true", help="a node for each instance")
    parser.add_argument("--maps", type=int, default=32)
    parser.add_argument("--size", type=int, default=4096, help="width of a map in pixels; a multiple of 8")
    options = parser.parse_args()
    {"mesh": mesh, "instances": instances, "textures": textures}[options.kind](options)


if __name__ == "__main__":
    main()
