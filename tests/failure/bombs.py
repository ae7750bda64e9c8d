"""Renders small files that would need excessive resources. Each render must end within seconds and keep to its memory
limit.

bombs.py EMBERLINE [--only NAME] [--keep DIR] [--list]

A seeded generator writes each file, which is rendered with --memory-limit in its own process. The process must end by
itself within K_SECONDS of processor time. Its exit code must be 0, or else 2 or 3 with exactly one line of errors. Its
peak of resident memory may exceed that of a plain scene by at most 1.1 times the limit. The plain scene has an image,
since image decoders take about a hundred megabytes to load.
"""
import argparse
import base64
import json
import os
import random
import struct
import subprocess
import sys
import tempfile
import time
import zlib

K_LIMIT = 256 << 20
K_SECONDS = 5.0  # of processor time, of both loading threads together
K_WALL = 60.0  # of wall-clock time, for busy machines

BOMBS = []


def bomb(*variants):
    """Registers a function once for each tuple of arguments."""

    def register(make):
        for args in variants or [()]:
            name = "_".join([make.__name__] + [str(a) for a in args])
            BOMBS.append((name, make, args))
        return make

    return register


class Gltf:
    """A scene with a triangle, a light and a camera; cases add to it."""

    def __init__(self):
        self.binary = bytearray()
        self.root = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
                     "bufferViews": [], "accessors": [], "meshes": [], "nodes": [], "materials": [],
                     "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
                     "extensionsUsed": ["KHR_lights_punctual"],
                     "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}}
        self.splices = {}
        self.points = self.floats("VEC3", [0, 0, 0, 1, 0, 0, 0, 1, 0])
        self.mesh({"attributes": {"POSITION": self.points}})
        self.root["nodes"] += [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 5]}]

    def view(self, data):
        while len(self.binary) % 4:
            self.binary.append(0)
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        return len(self.root["bufferViews"]) - 1

    def accessor(self, type_, component, count, view=None, **more):
        accessor = {"componentType": component, "count": count, "type": type_, **more}
        if view is not None:
            accessor["bufferView"] = view
        self.root["accessors"].append(accessor)
        return len(self.root["accessors"]) - 1

    def floats(self, type_, values):
        size = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[type_]
        return self.accessor(type_, 5126, len(values) // size, self.view(struct.pack(f"<{len(values)}f", *values)))

    def indices(self, values):
        return self.accessor("SCALAR", 5125, len(values), self.view(struct.pack(f"<{len(values)}I", *values)))

    def mesh(self, *primitives, **more):
        self.root["meshes"].append({"primitives": list(primitives), **more})
        return len(self.root["meshes"]) - 1

    def node(self, **node):
        self.root["nodes"].append(node)
        self.root["scenes"][0]["nodes"].append(len(self.root["nodes"]) - 1)
        return len(self.root["nodes"]) - 1

    def splice(self, placeholder, text):
        """Replaces the string `placeholder` by text in the file. This is much faster than adding objects, and the text
        need not be valid JSON."""
        self.splices[json.dumps(placeholder)] = text

    def write(self, path):
        self.root["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.root)
        for placeholder, replacement in self.splices.items():
            text = text.replace(placeholder, replacement)
        data = text.encode()
        data += b" " * (-len(data) % 4)
        binary = bytes(self.binary) + b"\0" * (-len(self.binary) % 4)
        with open(path, "wb") as f:
            f.write(struct.pack("<4sII", b"glTF", 2, 28 + len(data) + len(binary)))
            f.write(struct.pack("<I4s", len(data), b"JSON") + data)
            f.write(struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def many(text, count):
    return ",".join([text] * count)


# ---- many objects --------------------------------------------------------------------------------

OBJECTS = {
    "nodes": '{}',
    "named_nodes": '{"name":"n"}',
    "moved_nodes": '{"translation":[1,2,3]}',
    "mesh_nodes": '{"mesh":0}',
    "camera_nodes": '{"camera":0}',
    "light_nodes": '{"extensions":{"KHR_lights_punctual":{"light":0}}}',
    "materials": '{}',
    "textured_materials": '{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}',
    "cameras": '{"type":"perspective","perspective":{"yfov":1,"znear":1}}',
    "accessors": '{"componentType":5126,"type":"SCALAR","count":1}',
    "bufferViews": '{"buffer":0,"byteLength":1}',
    "textures": '{}',
    "samplers": '{}',
    "images": '{"bufferView":0,"mimeType":"image/png"}',
    "skins": '{"joints":[0]}',
    "meshes": '{"primitives":[{"attributes":{"POSITION":0}}]}',
    "scenes": '{}',
    "animations": '{"channels":[],"samplers":[]}',
    "buffers": '{"byteLength":1,"uri":"data:application/octet-stream;base64,AA=="}',
}


@bomb(*[(name, count) for name in OBJECTS for count in (30000, 300000)])
def objects(rng, name, count):
    g = Gltf()
    array = name.split("_")[-1]
    kept = g.root.setdefault(array, [])
    if name == "textured_materials":
        g.root["textures"] = [{"source": 0}]
        g.root["images"] = [{"uri": "data:image/png;base64,AAAA"}]
    first = len(kept)
    kept.append("@@")
    g.splice("@@", many(OBJECTS[name], count))
    if array == "nodes" and name != "nodes":
        g.root["scenes"][0]["nodes"].append("@roots")
        g.splice("@roots", ",".join(map(str, range(first, first + count))))
    return g


@bomb((1000000,))
def empty_nodes(rng, count):
    return objects(rng, "nodes", count)


@bomb((1000000,))
def empty_materials(rng, count):
    return objects(rng, "materials", count)


@bomb((1000000,))
def lamps(rng, count):
    return objects(rng, "light_nodes", count)


@bomb((1000000,))
def views_into_it(rng, count):
    return objects(rng, "camera_nodes", count)


@bomb((30000,), (300000,))
def distinct_lights(rng, count):
    g = Gltf()
    g.root["extensions"]["KHR_lights_punctual"]["lights"].append("@@")
    g.splice("@@", many('{"type":"point"}', count))
    return g


@bomb((30000,), (300000,))
def variants(rng, count):
    g = Gltf()
    g.root["extensions"]["KHR_materials_variants"] = {"variants": ["@@"]}
    g.splice("@@", many('{"name":"v"}', count))
    return g


@bomb((30000,), (300000,))
def extension_names(rng, count):
    g = Gltf()
    g.root["extensionsUsed"].append("@@")
    g.splice("@@", ",".join(f'"E{i}"' for i in range(count)))
    return g


@bomb((30000,), (300000,))
def unknown_modes(rng, count):
    g = Gltf()
    g.root["meshes"][0]["primitives"].append("@@")
    g.splice("@@", many('{"mode":0,"attributes":{"POSITION":0}}', count))
    return g


@bomb((10000,), (100000,))
def primitives(rng, count):
    g = Gltf()
    g.root["meshes"][0]["primitives"].append("@@")
    g.splice("@@", many('{"attributes":{"POSITION":0}}', count))
    return g


@bomb((10000,), (50000,))
def meshes_without_their_uv(rng, count):
    """The warning for each mesh contains its name."""
    g = Gltf()
    g.root["images"] = [{"uri": "data:image/png;base64," + PNG}]
    g.root["textures"] = [{"source": 0}]
    g.root["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}}}]
    g.root["meshes"].append("@m")
    g.splice("@m", many('{"primitives":[{"material":0,"attributes":{"POSITION":0}}]}', count))
    g.root["nodes"].append("@n")
    g.splice("@n", ",".join(f'{{"mesh":{i + 1}}}' for i in range(count)))
    g.root["scenes"][0]["nodes"].append("@r")
    g.splice("@r", ",".join(str(i + 2) for i in range(count)))
    return g


def png_chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


# A PNG with a single white pixel.
PNG = base64.b64encode(b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0))
                       + png_chunk(b"IDAT", zlib.compress(b"\0\xff\xff\xff")) + png_chunk(b"IEND", b"")).decode()


def with_image():
    g = Gltf()
    g.root["images"] = [{"uri": "data:image/png;base64," + PNG}]
    g.root["textures"] = [{"source": 0}]
    g.root["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    primitive = g.root["meshes"][0]["primitives"][0]
    primitive["material"] = 0
    primitive["attributes"]["TEXCOORD_0"] = g.floats("VEC2", [0, 0, 1, 0, 0, 1])
    return g


# ---- deep ----------------------------------------------------------------------------------------


@bomb((1000,), (10000,), (100000,), (300000,))
def chain_of_parents(rng, depth):
    g = Gltf()
    first = len(g.root["nodes"])
    g.root["nodes"].append("@@")
    g.splice("@@", ",".join(f'{{"children":[{first + i + 1}]}}' for i in range(depth)) + ',{"mesh":0}')
    g.root["scenes"][0]["nodes"].append(first)
    return g


@bomb((100000,))
def cycle_of_parents(rng, depth):
    g = Gltf()
    first = len(g.root["nodes"])
    g.root["nodes"].append("@@")
    g.splice("@@", ",".join(f'{{"children":[{first + (i + 1) % depth}]}}' for i in range(depth)))
    return g


@bomb((100000,))
def one_parent_of_all(rng, count):
    g = Gltf()
    first = len(g.root["nodes"])
    g.node(children=["@c"])
    g.splice("@c", ",".join(str(first + 1 + i) for i in range(count)))
    g.root["nodes"].append("@@")
    g.splice("@@", many('{"mesh":0}', count))
    return g


@bomb(("[", 1000), ("[", 100000), ("[", 1000000), ('{"a":', 1000), ('{"a":', 100000), ('{"a":', 1000000))
def nested_json(rng, opening, depth):
    g = Gltf()
    closing = {"[": "]", '{"a":': "}"}[opening]
    g.root["extras"] = "@@"
    g.splice("@@", opening * depth + "0" + closing * depth)
    return g


# ---- JSON ----------------------------------------------------------------------------------------


@bomb(("[]", 100000), ("[]", 1000000), ("{}", 1000000), ("0", 3000000), ('""', 1000000), ("[[[[]]]]", 300000),
      ('{"":{"":0}}', 300000))
def many_values(rng, value, count):
    g = Gltf()
    g.root["extras"] = ["@@"]
    g.splice("@@", many(value, count))
    return g


@bomb((100000,), (500000,))
def many_members(rng, count):
    g = Gltf()
    g.root["extras"] = "@@"
    g.splice("@@", "{" + ",".join(f'"{i}":0' for i in range(count)) + "}")
    return g


@bomb((100000,))
def equal_members(rng, count):
    g = Gltf()
    g.root["extras"] = "@@"
    g.splice("@@", "{" + many('"a":0', count) + "}")
    return g


@bomb((10 << 20,), (40 << 20,))
def long_name(rng, length):
    g = Gltf()
    g.root["nodes"][0]["name"] = "n" * length
    return g


@bomb((1 << 20,), (8 << 20,))
def long_name_of_many(rng, length):
    g = Gltf()
    g.root["cameras"][0]["name"] = "n" * length
    for i in range(500):
        g.node(camera=0)
    return g


@bomb(("meshes",), ("nodes",), ("lights",))
def long_name_of_its_uses(rng, kind):
    """A name of one megabyte, shared by many primitives, instances or lights."""
    g = Gltf()
    name, count = "n" * (1 << 20), 1000
    if kind == "meshes":
        g.root["meshes"][0]["name"] = name
        g.root["meshes"][0]["primitives"].append("@@")
        g.splice("@@", many('{"attributes":{"POSITION":0}}', count))
    elif kind == "nodes":
        g.root["extensionsUsed"].append("EXT_mesh_gpu_instancing")
        g.node(mesh=0, name=name, extensions={"EXT_mesh_gpu_instancing": {"attributes": {
            "TRANSLATION": g.accessor("VEC3", 5126, count)}}})
    else:
        g.root["extensions"]["KHR_lights_punctual"]["lights"][0]["name"] = name
        for _ in range(count):
            g.node(extensions={"KHR_lights_punctual": {"light": 0}})
    return g


# ---- accessors -----------------------------------------------------------------------------------


@bomb((10, 1000), (10, 100000), (1000, 100000), (100000, 20000))
def shared_accessor(rng, triangles, uses):
    """Primitives that all use the same vertices."""
    g = Gltf()
    points = g.floats("VEC3", [rng.uniform(-1, 1) for _ in range(9 * triangles)])
    g.root["meshes"][0]["primitives"].append("@@")
    g.splice("@@", many(f'{{"attributes":{{"POSITION":{points}}}}}', uses))
    return g


@bomb((1000,), (100000,))
def shared_by_nodes_with_weights(rng, uses):
    g = Gltf()
    points = g.floats("VEC3", [rng.uniform(-1, 1) for _ in range(9 * 3000)])
    mesh = g.mesh({"attributes": {"POSITION": points}, "targets": [{"POSITION": points}]})
    first = len(g.root["nodes"])
    g.root["nodes"].append("@@")
    g.splice("@@", ",".join(f'{{"mesh":{mesh},"weights":[{i + 1}]}}' for i in range(uses)))
    g.root["scenes"][0]["nodes"].append("@r")
    g.splice("@r", ",".join(map(str, range(first, first + uses))))
    return g


@bomb((1000, 1000), (100000, 1000), (1000, 100000))
def morph_targets(rng, vertices, targets):
    g = Gltf()
    vertices -= vertices % 3
    points = g.floats("VEC3", [rng.uniform(-1, 1) for _ in range(3 * vertices)])
    mesh = g.mesh({"attributes": {"POSITION": points}, "targets": ["@t"]}, weights=["@w"])
    g.splice("@t", many(f'{{"POSITION":{points}}}', targets))
    g.splice("@w", many("1", targets))
    g.node(mesh=mesh)
    return g


@bomb((1000,), (1000000,), (30000000,), (100000000,), (4000000000,), (1 << 53,))
def zeros(rng, count):
    """An accessor without data, whose elements are zeros."""
    g = Gltf()
    g.mesh({"attributes": {"POSITION": g.accessor("VEC3", 5126, count)}})
    g.node(mesh=1)
    return g


@bomb((1000000,), (100000000,), (4000000000,))
def sparse_over_zeros(rng, count):
    g = Gltf()
    accessor = g.accessor("VEC3", 5126, count, sparse={
        "count": 1, "indices": {"bufferView": g.view(struct.pack("<I", 0)), "componentType": 5125},
        "values": {"bufferView": g.view(struct.pack("<3f", 1, 2, 3))}})
    g.mesh({"attributes": {"POSITION": accessor}})
    g.node(mesh=1)
    return g


@bomb((1000,), (100000,))
def zeros_in_every_primitive(rng, uses):
    g = Gltf()
    g.view(bytes(1 << 20))
    zeros_ = g.accessor("VEC3", 5126, 900000)
    g.root["meshes"][0]["primitives"].append("@@")
    g.splice("@@", many(f'{{"attributes":{{"POSITION":{zeros_}}}}}', uses))
    return g


@bomb((1,), (4,), (40,))
def overlapping_elements(rng, stride):
    """Elements may not overlap: the stride must be at least the size of an element."""
    g = Gltf()
    view = g.view(bytes(rng.randrange(256) for _ in range(400000)))
    g.root["bufferViews"][view]["byteStride"] = stride
    g.mesh({"attributes": {"POSITION": g.accessor("VEC3", 5126, 399988 // max(stride, 12), view)}})
    g.node(mesh=1)
    return g


@bomb((1000,), (100000,))
def overlapping_views(rng, uses):
    """Many views of the same piece of the buffer. Each view has its own accessor and primitive."""
    g = Gltf()
    view = g.view(struct.pack("<3000f", *[rng.uniform(-1, 1) for _ in range(3000)]))
    at = g.root["bufferViews"][view]["byteOffset"]
    views, accessors = len(g.root["bufferViews"]), len(g.root["accessors"])
    g.root["bufferViews"].append("@v")
    g.splice("@v", many(f'{{"buffer":0,"byteOffset":{at},"byteLength":12000}}', uses))
    g.root["accessors"].append("@a")
    g.splice("@a", ",".join(f'{{"bufferView":{views + i},"componentType":5126,"count":999,"type":"VEC3"}}'
                            for i in range(uses)))
    g.root["meshes"][0]["primitives"].append("@p")
    g.splice("@p", ",".join(f'{{"attributes":{{"POSITION":{accessors + i}}}}}' for i in range(uses)))
    return g


@bomb((2,), (4,), (30,), (100000,))
def texture_coordinates(rng, sets):
    g = Gltf()
    points = g.floats("VEC3", [rng.uniform(-1, 1) for _ in range(9 * 20000)])
    uv = g.floats("VEC2", [rng.random() for _ in range(6 * 20000)])
    attributes = {"POSITION": points, "@@": 0}
    g.root["images"] = [{"uri": "data:image/png;base64," + PNG}]
    g.root["textures"] = [{"source": 0}]
    g.root["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": sets - 1}}}]
    g.mesh({"attributes": attributes, "material": 0})
    g.splice("@@", '"TEXCOORD_0":%d,' % uv + ",".join(f'"TEXCOORD_{i}":{uv}' for i in range(1, sets)) + ',"_X"')
    g.node(mesh=1)
    return g


@bomb((1000000000,), (2147483647,))
def texture_coordinate_number(rng, number):
    g = Gltf()
    g.root["images"] = [{"uri": "data:image/png;base64," + PNG}]
    g.root["textures"] = [{"source": 0}]
    g.root["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": number}}}]
    g.root["meshes"][0]["primitives"][0]["material"] = 0
    return g


@bomb((3, 100000), (100000, 10), (1000, 1000))
def joints(rng, count, nodes):
    """Skinned nodes that share a skin. The work is the number of nodes times the number of joints."""
    g = Gltf()
    joint = g.accessor("VEC4", 5121, 3, g.view(bytes(12)))
    weight = g.floats("VEC4", [1, 0, 0, 0] * 3)
    g.root["meshes"][0]["primitives"][0]["attributes"].update({"JOINTS_0": joint, "WEIGHTS_0": weight})
    g.root["skins"] = [{"joints": ["@j"]}]
    first = len(g.root["nodes"])
    g.root["nodes"].append("@@")
    g.splice("@@", many("{}", count) + "," + many('{"mesh":0,"skin":0}', nodes))
    g.splice("@j", ",".join(map(str, range(first, first + count))))
    g.root["scenes"][0]["nodes"].append("@r")
    g.splice("@r", ",".join(map(str, range(first + count, first + count + nodes))))
    return g


# ---- instances -----------------------------------------------------------------------------------


@bomb((1000,), (100000,), (1000000,))
def instanced_triangle(rng, count):
    return objects(rng, "mesh_nodes", count)


@bomb((1000,), (100000,), (10000000,), (4000000000,))
def gpu_instances(rng, count):
    """EXT_mesh_gpu_instancing with an accessor without data."""
    g = Gltf()
    g.root["extensionsUsed"].append("EXT_mesh_gpu_instancing")
    g.node(mesh=0, extensions={"EXT_mesh_gpu_instancing": {"attributes": {
        "TRANSLATION": g.accessor("VEC3", 5126, count)}}})
    return g


@bomb((1000, 1000), (100, 100000))
def instanced_instances(rng, nodes, count):
    g = Gltf()
    g.root["extensionsUsed"].append("EXT_mesh_gpu_instancing")
    places = g.accessor("VEC3", 5126, count, g.view(bytes(12 * count)))
    for _ in range(nodes):
        g.node(mesh=0, extensions={"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}})
    return g


@bomb((300, 300), (10, 100000), (100000, 10))
def variants_of_primitives(rng, variants_, primitives_):
    g = Gltf()
    g.root["extensionsUsed"].append("KHR_materials_variants")
    g.root["materials"] = [{}]
    g.root["extensions"]["KHR_materials_variants"] = {"variants": [{"name": str(i)} for i in range(variants_)]}
    mapping = json.dumps({"mappings": [{"material": 0, "variants": list(range(variants_))}]})
    g.root["meshes"][0]["primitives"].append("@@")
    g.splice("@@", many('{"attributes":{"POSITION":0},"material":0,"extensions":{"KHR_materials_variants":%s}}'
                        % mapping, min(primitives_, 20000000 // len(mapping))))
    return g


# ---- lamps ---------------------------------------------------------------------------------------


def shining(g, points):
    g.root["materials"] = [{"emissiveFactor": [1, 1, 1], "doubleSided": True}]
    g.node(mesh=g.mesh({"attributes": {"POSITION": g.floats("VEC3", points)}, "material": 0}))
    return g


@bomb((1000,), (40000,), (200000,))
def lamps_beside_a_far_one(rng, count):
    points = []
    for _ in range(count):
        x, y, z = (rng.uniform(-0.1, 0.1) for _ in range(3))
        points += [x, y, z, x + 1e-4, y, z, x, y + 1e-4, z]
    return shining(Gltf(), points + [1e6, 0, 0, 1e6, 1, 0, 1e6, 0, 1])


@bomb((1000,), (20000,))
def stacked_lamps(rng, count):
    return shining(Gltf(), [0, 0, 0, 1, 0, 0, 0, 1, 0] * count)


@bomb((1000,), (100000,))
def lamps_at_a_point(rng, count):
    points = []
    for _ in range(count):
        points += [rng.uniform(-1e-30, 1e-30) for _ in range(9)]
    return shining(Gltf(), points)


@bomb((20000,))
def long_lamps(rng, count):
    points = []
    for _ in range(count):
        points += [rng.uniform(-1, 1) for _ in range(9)]
    return shining(Gltf(), points)


@bomb((1000,), (100000,))
def stacked_triangles(rng, count):
    g = Gltf()
    g.node(mesh=g.mesh({"attributes": {"POSITION": g.floats("VEC3", [0, 0, 0, 1, 0, 0, 0, 1, 0] * count)}}))
    return g


# ---- compressed ----------------------------------------------------------------------------------


def varint(n):
    out = bytearray()
    while n >= 0x80:
        out.append(n & 0x7F | 0x80)
        n >>= 7
    out.append(n)
    return bytes(out)


@bomb(*[(method, faces, size) for method in (0, 1) for faces in (1000, 10000000, 4000000000) for size in (64, 100000)])
def draco_counts(rng, method, faces, size):
    """A header with large counts, followed by noise."""
    g = Gltf()
    counts = varint(faces) + varint(faces) if method == 0 else b"\0" + varint(faces) + varint(faces)
    data = b"DRACO" + bytes([2, 2, 1, method, 0, 0]) + counts + bytes(rng.randrange(256) for _ in range(size))
    view = g.view(data)
    g.root["extensionsUsed"].append("KHR_draco_mesh_compression")
    g.mesh({"attributes": {"POSITION": g.accessor("VEC3", 5126, faces)},
            "indices": g.accessor("SCALAR", 5125, 3 * faces),
            "extensions": {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": {"POSITION": 0}}}})
    g.node(mesh=1)
    return g


@bomb(*[(mode, count, size) for mode in ("ATTRIBUTES", "TRIANGLES", "INDICES")
        for count in (3000, 3000000, 3000000000) for size in (64, 100000)])
def meshopt_counts(rng, mode, count, size):
    g = Gltf()
    stride = 256 if mode == "ATTRIBUTES" else 4
    first = {"ATTRIBUTES": 0xA0, "TRIANGLES": 0xE1, "INDICES": 0xD1}[mode]
    data = g.view(bytes([first]) + bytes(size - 1))
    at = g.root["bufferViews"][data]
    g.root["extensionsUsed"].append("EXT_meshopt_compression")
    g.root["bufferViews"].append({"buffer": 0, "byteLength": count * stride, "extensions": {"EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": at["byteOffset"], "byteLength": size, "byteStride": stride, "count": count,
        "mode": mode}}})
    return g


@bomb((100,), (10000,))
def meshopt_views_of_one_stream(rng, views):
    g = Gltf()
    size = 20000
    data = g.view(bytes([0xA0]) + bytes(size - 1))
    at = g.root["bufferViews"][data]["byteOffset"]
    count = size // 4 - 1
    g.root["extensionsUsed"].append("EXT_meshopt_compression")
    g.root["bufferViews"].append("@@")
    g.splice("@@", many(json.dumps({"buffer": 0, "byteLength": count * 256, "extensions": {
        "EXT_meshopt_compression": {"buffer": 0, "byteOffset": at, "byteLength": size, "byteStride": 256, "count": count,
                                    "mode": "ATTRIBUTES"}}}), views))
    return g


# ---- wide and tall -------------------------------------------------------------------------------


@bomb((1e-44,), (1e-30,), (1e-20,), (1e-6,), (1e6,), (1e15,), (9e17,), (3e38,))
def sizes(rng, size):
    g = Gltf()
    g.node(mesh=g.mesh({"attributes": {"POSITION": g.floats("VEC3", [0, 0, 0, size, 0, 0, 0, size, 0])}}))
    return g


@bomb((1e-18, "orthographic"), (5e18, "orthographic"), (1e-300, "orthographic"), (1e-300, "perspective"), (1e-18, "perspective"), (1e300, "orthographic"),
      (3.14159265358979, "perspective"))
def views(rng, size, kind):
    g = Gltf()
    g.root["cameras"] = [{"type": "orthographic", "orthographic": {"xmag": size, "ymag": size, "znear": 0, "zfar": 1}}
                         if kind == "orthographic" else
                         {"type": "perspective", "perspective": {"yfov": size, "znear": 0.1}}]
    return g


@bomb((16, 16), (65536, 1), (1, 65536), (65536, 65536), (20000, 20000))
def frames(rng, width, height):
    g = Gltf()
    g.arguments = ["--size", f"{width}x{height}", "-o", "frame.png"]
    return g


@bomb(("bisection", 20000), ("adaptive", 20000), ("bisection", 65536), ("adaptive", 65536))
def frames_of_drivers(rng, driver, size):
    g = Gltf()
    g.arguments = ["--size", f"{size}x{size}", "--driver", driver]
    return g


# ---- images --------------------------------------------------------------------------------------


def png(width, height, depth, colour):
    rows = zlib.compress(bytes(1 << 20), 9)
    return (b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)) +
            png_chunk(b"IDAT", rows) + png_chunk(b"IEND", b""))


@bomb((16, 16, 8), (4096, 4096, 8), (16384, 16384, 16), (30000, 30000, 8), (65535, 65535, 16), (2147483647, 1, 8))
def image_size(rng, width, height, depth):
    g = Gltf()
    g.root["images"] = [{"bufferView": g.view(png(width, height, depth, 6)), "mimeType": "image/png"}]
    g.root["textures"] = [{"source": 0}]
    g.root["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    g.root["meshes"][0]["primitives"][0]["material"] = 0
    return g


@bomb((100,), (3000,))
def images_of_one_view(rng, count):
    """Large images that share a buffer view. Each image is used by a material."""
    g = Gltf()
    view = g.view(png(512, 512, 8, 6))
    g.root["images"] = ["@i"]
    g.splice("@i", many(f'{{"bufferView":{view},"mimeType":"image/png"}}', count))
    g.root["textures"] = ["@t"]
    g.splice("@t", ",".join(f'{{"source":{i}}}' for i in range(count)))
    g.root["materials"] = ["@m"]
    g.splice("@m", ",".join(f'{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":{i}}}}}}}' for i in range(count)))
    g.root["meshes"][0]["primitives"].append("@p")
    g.splice("@p", ",".join(f'{{"material":{i},"attributes":{{"POSITION":0}}}}' for i in range(count)))
    return g


@bomb((30000,), (200000,))
def texture_transforms(rng, count):
    g = Gltf()
    g.root["extensionsUsed"].append("KHR_texture_transform")
    g.root["images"] = [{"uri": "data:image/png;base64," + PNG}]
    g.root["textures"] = [{"source": 0}]
    g.root["materials"] = ["@m"]
    g.splice("@m", many('{"normalTexture":{"index":0,"extensions":{"KHR_texture_transform":{"scale":[1e30,1e-30],'
                        '"rotation":1e300,"texCoord":0}}}}', count))
    g.root["meshes"][0]["primitives"][0]["material"] = count - 1
    return g


# ---- running -------------------------------------------------------------------------------------


def run(program, folder, path, arguments=()):
    """Returns exit code, message, processor seconds, peak bytes."""
    size = [] if "--size" in arguments else ["--size", "8x8"]
    command = [program, "render", path, "-o", "out.exr", "--spp", "1", "--max-depth", "2", "--threads", "2",
               "--memory-limit", str(K_LIMIT)] + size + list(arguments)
    start = time.monotonic()
    with open(os.path.join(folder, "stderr"), "w+") as errors:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, cwd=folder)
        timer = None
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - start > K_WALL:
                process.kill()
                timer = True
            time.sleep(0.005)
        process.returncode = os.waitstatus_to_exitcode(status)
        errors.seek(0)
        text = errors.read()
    code = "hung" if timer else process.returncode
    return code, text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def failure(code, text, seconds, peak, plain):
    if code not in (0, 2, 3):
        return f"ended with {code}"
    errors = [line for line in text.splitlines() if line.startswith("emberline: error") or line.startswith("error")]
    if code != 0 and len(errors) != 1:
        return f"{len(errors)} lines of errors"
    if seconds > K_SECONDS:
        return f"took {seconds:.1f} s"
    if peak - plain > 1.1 * K_LIMIT:
        return f"took {(peak - plain) >> 20} MiB of {K_LIMIT >> 20}"
    return None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--only", default="")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--every", type=int, default=1, help="only every n-th")
    parser.add_argument("--keep", help="folder for the files, instead of one that is removed")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    chosen = [b for b in BOMBS if options.only in b[0]][:: options.every]
    failures = []
    total = 0.0
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or temporary
        os.makedirs(folder, exist_ok=True)
        path = os.path.join(folder, "plain.glb")
        with_image().write(path)
        code, text, _, plain = run(program, folder, path)
        if code != 0:
            sys.exit(f"the plain scene ended with {code}: {text}")
        for name, make, arguments in chosen:
            path = os.path.join(folder, ("bomb" if not options.keep else name.replace("/", "_").replace(" ", "_")) + ".glb")
            scene = make(random.Random(name), *arguments)
            scene.write(path)
            code, text, seconds, peak = run(program, folder, path, getattr(scene, "arguments", ()))
            total += seconds
            wrong = failure(code, text, seconds, peak, plain)
            if wrong:
                failures.append(name)
            if wrong or options.list:
                last = text.strip().splitlines()[-1][:150] if text.strip() else ""
                print(f"{'FAIL ' + wrong if wrong else 'ok':40} {name:45} {code} {seconds:5.2f} s "
                      f"{(peak - plain) / (1 << 20):6.0f} MiB  {last}", flush=True)
    print(f"{len(chosen)} bombs, {len(failures)} failures, {total:.0f} s of processor time")
    sys.exit(1 if failures or not chosen else 0)


if __name__ == "__main__":
    main()
