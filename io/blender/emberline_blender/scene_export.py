"""The evaluated scene as a .glb for Emberline.

Blender's own exporter writes each mesh with its materials once; where they stand, and the lights, are added to its file.
For that the meshes of the depsgraph are laid into a scene of their own, which is removed again: nothing of the user's is touched.
"""
import os
import types

import bpy
from mathutils import Vector

from . import lights, materials
from .command import Refused
from .glb import Glb, matrix

_MESHES = ("MESH", "CURVE", "SURFACE", "FONT", "META")


class _Scratch:
    """A scene of our own, with all that is put into it."""

    def __init__(self):
        self.scene = bpy.data.scenes.new("Emberline export")
        self.ids = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        bpy.data.scenes.remove(self.scene)
        bpy.data.batch_remove(self.ids)

    def add(self, name, mesh):
        placed = bpy.data.objects.new(name, mesh)
        self.ids += [placed, mesh]
        self.scene.collection.objects.link(placed)


class _Context:
    """Blender's context, but for the window: the exporter turns that to the scene it exports, which the user would see, and
    for which Blender evaluates all of the user's scene twice more."""

    def __init__(self, context):
        self._context = context
        self.window = types.SimpleNamespace()

    def __getattr__(self, name):
        return getattr(self._context, name)


def _export(scratch, path):
    wanted = {
        "filepath": path,
        "check_existing": False,
        "export_format": "GLB",
        "use_active_scene": True,
        "export_animations": False,
        "export_current_frame": True,
        "export_skins": False,
        "export_morph": False,
        "export_apply": False,
        "export_colors": False,
        "export_vertex_color": "MATERIAL",
        "export_all_vertex_colors": False,
        "export_tangents": False,
        "export_lights": False,
        "export_cameras": False,
        "export_extras": False,
        "export_yup": True,
    }
    operator = bpy.ops.export_scene.gltf
    try:
        known = set(operator.get_rna_type().properties.keys())
    except KeyError:
        raise Refused("Emberline: enable the add-on 'glTF 2.0 format' in Preferences > Add-ons") from None
    override = {"scene": scratch.scene, "view_layer": scratch.scene.view_layers[0], "selected_objects": []}
    context = bpy.context
    with context.temp_override(**override, active_object=None, object=None):
        bpy.context = _Context(context)
        try:
            operator(**{name: value for name, value in wanted.items() if name in known})
        finally:
            bpy.context = context


class Parts:
    """What the exporter has written: a file, and which of its meshes is whose."""

    def __init__(self, path, meshes, original_names):
        self.path, self.meshes, self.original_names = path, meshes, original_names


class Export:
    """Writes scene.glb to `folder` from the depsgraph. Afterwards `groups` says which layer of light belongs to which of
    Blender's light groups, of those in `light_groups`. `parts`: of an earlier export, whose meshes and materials still hold:
    then only what stands where is new, unless there is a mesh that it lacks."""

    def __init__(self, depsgraph, folder, light_groups=(), parts=None):
        self._depsgraph = depsgraph
        self._light_groups = set(light_groups)
        self._placed = []  # (object's name, mesh's key, matrix, light group)
        self._lights = []  # (name, data, matrix, light group, unseen)
        self._low, self._high = Vector((1e30,) * 3), Vector((-1e30,) * 3)
        self.groups = {}
        self.path = os.path.join(folder, "scene.glb")
        if not (parts and self._gather(None, parts)):
            parts = self._export_meshes(folder)
        self.parts = parts
        glb = Glb(parts.path) if parts.path else Glb()
        self._place(glb)
        glb.write(self.path)

    def _export_meshes(self, folder):
        path = os.path.join(folder, "meshes.glb")
        with _Scratch() as scratch:
            parts = Parts("", {}, {})
            self._gather(scratch, parts)
            if self._placed:
                try:
                    _export(scratch, path)
                except RuntimeError as error:
                    line = str(error).strip().splitlines()[-1]
                    raise Refused(f"Emberline: Blender's glTF exporter failed: {line}") from error
                parts.path = path
        return parts

    def lights(self):
        """Name of the object and the light of each."""
        return [(name, data) for name, data, *_ in self._lights]

    def _group(self, placed):
        group = getattr(placed, "lightgroup", "")
        return group if group in self._light_groups else ""

    def _gather(self, scratch, parts):
        """Without `scratch` no mesh is made: False where one is missing."""
        copies = materials.Copies(self._depsgraph, scratch.ids, parts.original_names) if scratch else None
        self._placed, self._lights, meshes = [], [], parts.meshes
        scene = self._depsgraph.scene_eval
        camera = scene.camera.evaluated_get(self._depsgraph) if scene.camera else None
        for instance in self._depsgraph.object_instances:
            placed = instance.object
            if not instance.show_self:
                continue
            world = instance.matrix_world.copy()
            if placed.type == "LIGHT":
                unseen = not placed.visible_camera and lights.in_view(scene, camera, placed.data, world)
                self._lights.append((placed.name, placed.data, world, self._group(placed), unseen))
                continue
            if placed.type not in _MESHES or not placed.data:
                continue
            worn = tuple(slot.material.name_full if slot.material else "" for slot in placed.material_slots)
            # Objects without modifiers share what they are made of; what others are made of has an address of its own.
            key = (placed.data.as_pointer(), placed.type, worn)
            if placed.type != "MESH":
                key = (placed.original.as_pointer(), placed.type, worn)
            if key not in meshes:
                if not scratch:
                    return False
                meshes[key] = self._mesh(scratch, placed, len(meshes), copies)
            if meshes[key]:
                self._placed.append((placed.name, meshes[key], world, self._group(placed)))
                for corner in placed.bound_box:
                    at = world @ Vector(corner)
                    self._low = Vector(map(min, self._low, at))
                    self._high = Vector(map(max, self._high, at))
        return True

    def _mesh(self, scratch, placed, index, copies):
        try:
            mesh = bpy.data.meshes.new_from_object(placed, depsgraph=self._depsgraph)
        except RuntimeError:
            return None  # of a kind that has no mesh: limits.py lists it
        if not mesh.polygons:
            bpy.data.meshes.remove(mesh)
            return None
        for i, slot in enumerate(placed.material_slots):
            if i >= len(mesh.materials):
                mesh.materials.append(None)
            mesh.materials[i] = copies.of(slot.material)
        name = f"emberline mesh {index}"
        scratch.add(name, mesh)
        return name

    def _place(self, glb):
        # The exporter's nodes say which mesh is which; ours take their place.
        meshes = {node["name"]: node["mesh"] for node in glb.json.get("nodes", []) if "mesh" in node}
        glb.json["nodes"] = nodes = []
        materials.restore_names(glb, self.parts.original_names)
        materials.complete(glb)
        split = materials.LightGroups(glb)
        placed_nodes = []
        for name, key, world, group in self._placed:
            values = matrix(world)
            if key in meshes and values:
                mesh = split.mesh(meshes[key], group)
                placed_nodes.append(len(nodes))
                nodes.append({"name": name, "mesh": mesh, "matrix": values})
        glb.json["scene"], glb.json["scenes"] = 0, [{"nodes": placed_nodes}]
        self._add_lights(glb, bool(placed_nodes))
        split.name_emitters()
        self.groups = {**split.layers, **self._light_layers}
        if not glb.json["nodes"]:
            raise Refused("Emberline: there is nothing to render; the scene has neither a mesh nor a light")

    def _add_lights(self, glb, any_mesh):
        centre = (self._low + self._high) / 2 if any_mesh else Vector((0, 0, 0))
        radius = max((self._high - self._low).length / 2, 1e-6) if any_mesh else 1.0
        self._light_layers = {}
        for index, (name, data, world, group, unseen) in enumerate(self._lights):
            # With light groups a layer must be known by its name, which two lights may share.
            layer = f"group{index}-{name}" if group else name
            if group:
                self._light_layers[layer] = group
            lights.add(glb, layer, data, world, centre, radius, unseen)
