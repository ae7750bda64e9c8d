"""A .glb as its JSON and its buffer, to change what Blender's exporter has written and to add to it."""
import json
import math
import struct

_JSON, _BIN = 0x4E4F534A, 0x004E4942


class Glb:
    def __init__(self, path=None):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.buffer = bytearray()
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

    def use(self, extension):
        used = self.json.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)

    def _accessor(self, numbers, code, component, kind, **more):
        self.buffer += bytes(-len(self.buffer) % 4)
        data = struct.pack(f"<{len(numbers)}{code}", *numbers)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data)})
        self.buffer += data
        count = len(numbers) // (3 if kind == "VEC3" else 1)
        accessor = {"bufferView": view, "componentType": component, "count": count, "type": kind, **more}
        return self.add("accessors", accessor)

    def add_emitter(self, name, points, triangles, radiance):
        """A mesh that shines with `radiance` to the side its triangles are seen from, and reflects nothing."""
        most = max(radiance)
        emission = {"emissiveFactor": [c / most for c in radiance]} if most > 0 else {}
        material = {
            "name": name,
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
            **emission,
        }
        self.use("KHR_materials_specular")
        if most > 0:
            self.use("KHR_materials_emissive_strength")
            material["extensions"]["KHR_materials_emissive_strength"] = {"emissiveStrength": most}
        count = 3 * len(points)
        flat = struct.unpack(f"<{count}f", struct.pack(f"<{count}f", *[x for p in points for x in p]))
        bounds = {"min": [min(flat[i::3]) for i in range(3)], "max": [max(flat[i::3]) for i in range(3)]}
        positions = self._accessor(flat, "f", 5126, "VEC3", **bounds)
        indices = self._accessor([i for t in triangles for i in t], "I", 5125, "SCALAR")
        primitive = {
            "attributes": {"POSITION": positions},
            "indices": indices,
            "material": self.add("materials", material),
        }
        return self.add("meshes", {"name": name, "primitives": [primitive]})


def matrix(m):
    """A node's "matrix" of Blender's 4x4, in glTF's axes (Y up), column after column."""
    # C m C^-1 with C: (x, y, z) -> (x, z, -y)
    order, signs = (0, 2, 1, 3), (1, 1, -1, 1)
    values = [m[order[r]][order[c]] * signs[r] * signs[c] for c in range(4) for r in range(4)]
    return values if all(map(math.isfinite, values)) else None


def point(v):
    """glTF's axes of a point in Blender's."""
    return [v[0], v[2], -v[1]]
