"""Writes glTF 2.0 binary files. Rounds numbers to a grid before it stores them, so that differences in the last bit of
libm's results do not change the file."""

import json
import math
import struct

from .vec import axis_angle, facing, sub

_GRID = float(1 << 22)  # positions, normals and texture coordinates are multiples of 1 / _GRID, which is 2.4e-7
_FLOAT, _USHORT, _UINT = 5126, 5123, 5125
_ARRAY, _ELEMENTS = 34962, 34963


def srgb(code):
    """Converts '#rrggbb' to linear Rec. 709."""
    values = [int(code[i:i + 2], 16) / 255 for i in (1, 3, 5)]
    return tuple(v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in values)


def _number(x):
    x = float(f"{x:.6g}")
    return int(x) if x == int(x) and abs(x) < 1e9 else x


def _numbers(values):
    return [_number(v) for v in values]


def _snap(values):
    return [round(v * _GRID) / _GRID + 0.0 for v in values]


class Gltf:
    """One scene. Methods that add something return its glTF index. The file keeps the order of the calls."""

    def __init__(self, title):
        self._bin = bytearray()
        self._views = []
        self._accessors = []
        self._geometry = {}
        self._textured = set()
        self._lights = []
        self._extensions = set()
        self._doc = {"asset": {"version": "2.0", "generator": "emberline scenes/make_scenes.py",
                               "copyright": "Emberline, Apache-2.0"},
                     "scene": 0, "scenes": [{"name": title, "nodes": []}], "nodes": []}

    def _list(self, key):
        return self._doc.setdefault(key, [])

    def _add(self, key, item):
        self._list(key).append(item)
        return len(self._list(key)) - 1

    def _view(self, data, target=None):
        while len(self._bin) % 4:
            self._bin.append(0)
        view = {"buffer": 0, "byteOffset": len(self._bin), "byteLength": len(data)}
        if target:
            view["target"] = target
        self._bin += data
        self._views.append(view)
        return len(self._views) - 1

    def _accessor(self, values, kind, component=_FLOAT, target=None, bounds=False):
        """Adds an accessor for `values`, a list of tuples."""
        flat = [v for item in values for v in item]
        if component == _FLOAT:
            flat = _snap(flat)
        data = struct.pack(f"<{len(flat)}{ {_FLOAT: 'f', _USHORT: 'H', _UINT: 'I'}[component]}", *flat)
        accessor = {"bufferView": self._view(data, target), "componentType": component, "count": len(values),
                    "type": kind}
        if bounds:
            width = len(values[0])
            stored = struct.unpack(f"<{len(flat)}f", data) if component == _FLOAT else flat
            accessor["min"] = [min(stored[i::width]) for i in range(width)]
            accessor["max"] = [max(stored[i::width]) for i in range(width)]
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    def texture(self, png, name, nearest=False):
        image = self._add("images", {"name": name, "mimeType": "image/png", "bufferView": self._view(png)})
        required = ({"magFilter": 9728, "minFilter": 9728} if nearest else {"magFilter": 9729, "minFilter": 9987})
        required.update(wrapS=10497, wrapT=10497)
        samplers = self._list("samplers")
        if required not in samplers:
            samplers.append(required)
        return self._add("textures", {"name": name, "sampler": samplers.index(required), "source": image})

    def _slot(self, texture, repeat=None):
        slot = {"index": texture}
        if repeat:
            self._extensions.add("KHR_texture_transform")
            slot["extensions"] = {"KHR_texture_transform": {"scale": _numbers(repeat)}}
        return slot

    def material(self, name, colour=(1, 1, 1), metallic=0.0, roughness=0.5, texture=None, normal=None,
                 normal_scale=1.0, roughness_texture=None, emission=None, emission_texture=None, two_sided=False,
                 transmission=0.0, ior=None, attenuation=None, repeat=None, layers=None):
        """Adds a material. `colour` is linear, and `emission` is linear radiance. `attenuation` is (colour, distance)
        for solid glass. `repeat` tiles all textures of the material. `layers` maps the names of further extensions,
        without the prefix KHR_materials_, to their contents as in a glTF file."""
        pbr = {"baseColorFactor": _numbers(tuple(colour) + (1.0,)), "metallicFactor": _number(metallic),
               "roughnessFactor": _number(roughness)}
        if texture is not None:
            pbr["baseColorTexture"] = self._slot(texture, repeat)
        if roughness_texture is not None:
            pbr["metallicRoughnessTexture"] = self._slot(roughness_texture, repeat)
        out = {"name": name, "pbrMetallicRoughness": pbr}
        if normal is not None:
            out["normalTexture"] = dict(self._slot(normal, repeat), scale=_number(normal_scale))
        extensions = {}
        if emission is not None:
            strength = max(emission)
            out["emissiveFactor"] = _numbers(c / max(strength, 1.0) for c in emission)
            if strength > 1:
                extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": _number(strength)}
            if emission_texture is not None:
                out["emissiveTexture"] = self._slot(emission_texture)
        if transmission:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": _number(transmission)}
        if ior is not None:
            extensions["KHR_materials_ior"] = {"ior": _number(ior)}
        if attenuation is not None:
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1, "attenuationColor": _numbers(attenuation[0]),
                                                  "attenuationDistance": _number(attenuation[1])}
        for name_of, members in (layers or {}).items():
            extensions["KHR_materials_" + name_of] = {
                key: _numbers(value) if isinstance(value, (list, tuple)) else _number(value)
                for key, value in members.items()}
        if extensions:
            out["extensions"] = extensions
            self._extensions.update(extensions)
        if two_sided:
            out["doubleSided"] = True
        index = self._add("materials", out)
        if any(t is not None for t in (texture, normal, roughness_texture, emission_texture)):
            self._textured.add(index)
        return index

    def mesh(self, name, geometry, material):
        """Adds a mesh. If `geometry` is reused with another material, the buffers are shared."""
        required = ["POSITION", "NORMAL"]
        if material in self._textured:
            required.append("TEXCOORD_0")
        description = self._doc["materials"][material]
        if "normalTexture" in description or "KHR_materials_anisotropy" in description.get("extensions", {}):
            required.append("TANGENT")
        attributes = {name: self._attribute(geometry, name) for name in required}
        indices = self._attribute(geometry, "indices")
        primitive = {"attributes": attributes, "indices": indices, "material": material}
        return self._add("meshes", {"name": name, "primitives": [primitive]})

    def _attribute(self, geometry, name):
        key = (id(geometry), name)
        if key not in self._geometry:
            if name == "POSITION":
                accessor = self._accessor(geometry.positions, "VEC3", target=_ARRAY, bounds=True)
            elif name == "NORMAL":
                accessor = self._accessor(geometry.normals, "VEC3", target=_ARRAY)
            elif name == "TEXCOORD_0":
                accessor = self._accessor(geometry.uvs, "VEC2", target=_ARRAY)
            elif name == "TANGENT":
                accessor = self._accessor(geometry.tangents(), "VEC4", target=_ARRAY)
            else:
                component = _USHORT if len(geometry.positions) < 65536 else _UINT
                accessor = self._accessor([(i,) for i in geometry.indices], "SCALAR", component, _ELEMENTS)
            self._geometry[key] = (accessor, geometry)  # keeps the geometry alive, so that its id() stays unique
        return self._geometry[key][0]

    def node(self, name, mesh=None, translation=None, rotation=None, scale=None, children=None, root=True, **more):
        out = {"name": name}
        if mesh is not None:
            out["mesh"] = mesh
        if translation is not None:
            out["translation"] = _numbers(translation)
        if rotation is not None:
            out["rotation"] = _numbers(rotation)
        if scale is not None:
            out["scale"] = _numbers((scale,) * 3 if isinstance(scale, (int, float)) else scale)
        if children:
            out["children"] = children
        out.update(more)
        index = self._add("nodes", out)
        if root:
            self._doc["scenes"][0]["nodes"].append(index)
        return index

    def rotate_scene(self, degrees):
        """Makes everything added so far, including the camera, a child of a node that is rotated about +Y."""
        roots = list(self._doc["scenes"][0]["nodes"])
        self._doc["scenes"][0]["nodes"].clear()
        return self.node("turned", rotation=axis_angle((0, 1, 0), degrees), children=roots)

    def add_object(self, name, geometry, material, **placement):
        """Adds a mesh and a node that places it."""
        return self.node(name, self.mesh(name, geometry, material), **placement)

    def camera(self, name, eye, target, fov_y, aspect=16 / 9, near=0.01, far=None):
        perspective = {"yfov": _number(math.radians(fov_y)), "aspectRatio": _number(aspect), "znear": _number(near)}
        if far:
            perspective["zfar"] = far
        camera = self._add("cameras", {"name": name, "type": "perspective", "perspective": perspective})
        return self.node(name, translation=eye, rotation=facing(sub(eye, target)), camera=camera)

    def light(self, name, kind, colour, intensity, eye, target, inner=None, outer=None):
        """Adds a light that shines from `eye` towards `target`. `kind` is spot or directional. The intensity of a spot
        is in candela, and that of a directional light is in lux."""
        light = {"name": name, "type": kind, "color": _numbers(colour), "intensity": _number(intensity)}
        if kind == "spot":
            light["spot"] = {"innerConeAngle": _number(math.radians(inner)),
                             "outerConeAngle": _number(math.radians(outer))}
        self._lights.append(light)
        self._extensions.add("KHR_lights_punctual")
        return self.node(name, translation=eye, rotation=facing(sub(eye, target)),
                         extensions={"KHR_lights_punctual": {"light": len(self._lights) - 1}})

    def softbox(self, name, centre, target, geometry, emission, texture=None, roll_up=(0.0, 1.0, 0.0)):
        """Adds an emitting surface and turns it towards `target`. `geometry` must face +Z."""
        dark = self.material(name, (0, 0, 0), roughness=1.0, emission=emission, emission_texture=texture)
        return self.add_object(name, geometry, dark, translation=centre, rotation=facing(sub(target, centre), roll_up))

    def animate_rotation(self, name, node, times, rotations):
        sampler = {"input": self._accessor([(t,) for t in times], "SCALAR", bounds=True),
                   "output": self._accessor(rotations, "VEC4"), "interpolation": "LINEAR"}
        channel = {"sampler": 0, "target": {"node": node, "path": "rotation"}}
        return self._add("animations", {"name": name, "samplers": [sampler], "channels": [channel]})

    def glb(self):
        doc = dict(self._doc)
        if self._lights:
            doc["extensions"] = {"KHR_lights_punctual": {"lights": self._lights}}
        if self._extensions:
            doc["extensionsUsed"] = sorted(self._extensions)
        while len(self._bin) % 4:
            self._bin.append(0)
        doc["accessors"], doc["bufferViews"] = self._accessors, self._views
        doc["buffers"] = [{"byteLength": len(self._bin)}]
        text = json.dumps(doc, separators=(",", ":"), ensure_ascii=False).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(self._bin), 0x004E4942) + bytes(self._bin)
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks
