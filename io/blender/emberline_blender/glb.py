"""Holds a .glb as its JSON and its buffer, to modify and extend the output of Blender's exporter."""
import json
import struct

import numpy
from mathutils import Matrix

_JSON, _BIN = 0x4E4F534A, 0x004E4942


class Glb:
    def __init__(self, path=None):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.buffer = bytearray()
        self._default_material = None
        if path:
            self._read(path)

    def _read(self, path):
        with open(path, "rb") as file:
            data = file.read()
        at = 12
        while at + 8 <= len(data):
            size, kind = struct.unpack_from("<II", data, at)
            chunk = data[at + 8 : at + 8 + size]
            if kind == _JSON:
                self.json = json.loads(chunk)
            elif kind == _BIN:
                self.buffer = bytearray(chunk)
            at += 8 + size

    def write(self, path):
        if self.buffer:
            self.json["buffers"] = [{"byteLength": len(self.buffer)}]
        for member in [m for m, value in self.json.items() if value == [] or value == {}]:
            del self.json[member]
        text = json.dumps(self.json, ensure_ascii=False, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        self.buffer += bytes(-len(self.buffer) % 4)
        chunks = struct.pack("<II", len(text), _JSON) + text
        if self.buffer:
            chunks += struct.pack("<II", len(self.buffer), _BIN)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks) + len(self.buffer)))
            file.write(chunks)
            file.write(self.buffer)

    def add(self, member, item):
        items = self.json.setdefault(member, [])
        items.append(item)
        return len(items) - 1

    _LISTS = ("accessors", "bufferViews", "materials", "meshes")

    def end(self):
        """Returns the current sizes of the buffer and the lists, for truncate()."""
        return len(self.buffer), {member: len(self.json.get(member, ())) for member in self._LISTS}

    def truncate(self, end):
        """Removes everything added since end(), except for extensionsUsed. Also removes all nodes, cameras, animations
        and extensions."""
        del self.buffer[end[0] :]
        for member, count in end[1].items():
            if member in self.json:
                del self.json[member][count:]
        for member in ("nodes", "cameras", "animations", "extensions"):
            self.json.pop(member, None)

    def use(self, extension):
        used = self.json.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)

    def _accessor(self, values, component, kind, **more):
        self.buffer += bytes(-len(self.buffer) % 4)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": values.nbytes})
        self.buffer += values.tobytes()
        accessor = {"bufferView": view, "componentType": component, "count": len(values), "type": kind, **more}
        return self.add("accessors", accessor)

    def add_vectors(self, values, bounds=False):
        """Adds rows of two to four floats, or scalars. glTF requires `bounds` for positions and key times."""
        values = numpy.ascontiguousarray(values, "<f4")
        kind = "SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}"
        limits = {}
        if bounds:
            rows = values.reshape(len(values), -1)
            limits = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        return self._accessor(values, 5126, kind, **limits)

    def add_indices(self, triangles):
        return self._accessor(numpy.ascontiguousarray(triangles, "<u4").ravel(), 5125, "SCALAR")

    def default_material(self):
        """Returns the index of Blender's default grey, for faces without a material."""
        if self._default_material is None:
            plain = {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 1}
            self.use("KHR_materials_specular")
            self._default_material = self.add(
                "materials", {"pbrMetallicRoughness": plain, "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}
            )
        return self._default_material

    def add_emitter(self, name, points, triangles, radiance):
        """Adds a mesh that emits `radiance` from the front of its triangles and reflects nothing."""
        peak = max(radiance)
        emission = {"emissiveFactor": [c / peak for c in radiance]} if peak > 0 else {}
        material = {
            "name": name,
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
            **emission,
        }
        self.use("KHR_materials_specular")
        if peak > 0:
            self.use("KHR_materials_emissive_strength")
            material["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": peak}
        primitive = {
            "attributes": {"POSITION": self.add_vectors(points, bounds=True)},
            "indices": self.add_indices(triangles),
            "material": self.add("materials", material),
        }
        return self.add("meshes", {"name": name, "primitives": [primitive]})


def axes(m):
    """Converts Blender's 4x4 matrix to glTF's axes (Y up)."""
    # This is C m C^-1 with C: (x, y, z) -> (x, z, -y).
    order, signs = (0, 2, 1, 3), (1, 1, -1, 1)
    return Matrix([[m[order[r]][order[c]] * signs[r] * signs[c] for c in range(4)] for r in range(4)])


def flat(m):
    """Returns a node's "matrix", which is in column-major order."""
    return [m[r][c] for c in range(4) for r in range(4)]


def point(v):
    """Converts a point from Blender's axes to glTF's."""
    return [v[0], v[2], -v[1]]
