"""Exports the evaluated scene as a .glb for Emberline.

Blender's own exporter writes the materials: it gets a temporary scene with one triangle per material, so that
the user's scene is not touched. Meshes (once each), their nodes and the lights are then added to its file.
"""
import collections
import contextlib
import os
import types

import bpy
from mathutils import Vector

from . import camera, images, lights, materials
from .command import Refused
from .glb import Glb
from .meshes import Mesh
from .motion import Animation

_MESHES = ("MESH", "CURVE", "SURFACE", "FONT", "META")


class _Scratch:
    """A temporary scene with one triangle for each material in use, for the exporter."""

    def __init__(self, depsgraph):
        self.scene = bpy.data.scenes.new("Emberline export")
        self.ids, self.original_names, self.said = [], {}, []
        self._copies = materials.Copies(depsgraph, self.ids, self.original_names)
        self._triangles, self._wearers = {}, {}  # names by key; material and user by triangle

    def __enter__(self):
        return self

    def __exit__(self, *_):
        bpy.data.scenes.remove(self.scene)
        bpy.data.batch_remove(self.ids)

    def triangle(self, material, uv_maps, shown_uv_map, wearer):
        """Returns the triangle's name; `wearer` is the name of an object with the material. Textures refer to
        UV maps, so meshes with different UV maps need separate triangles."""
        worn = (self._copies.of(material), uv_maps, shown_uv_map)
        if worn not in self._triangles:
            mesh = bpy.data.meshes.new("emberline")
            placed = bpy.data.objects.new(f"emberline {len(self._triangles)}", mesh)
            self.ids += [placed, mesh]
            mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
            mesh.materials.append(worn[0])
            for name in uv_maps:
                mesh.uv_layers.new(name=name).active_render = name == shown_uv_map
            self.scene.collection.objects.link(placed)
            self._triangles[worn] = placed.name
            self._wearers[placed] = (material.name, wearer)
            for node in materials.image_nodes(material.original):
                if node.image.source == "TILED":
                    self.said += [f"{wearer}: {material.name}: {line}" for line in images.faults(node.image)]
        return self._triangles[worn]

    def export(self, folder):
        """Returns the exporter's file and the material index of each triangle."""
        if not self._triangles:
            return Glb(), {}
        path = os.path.join(folder, "materials.glb")
        try:
            _export(self, path)
        except _ExporterFailed as fault:
            raise Refused(f"Emberline: Blender's glTF exporter failed{self._blame(path)}: {fault}") from fault
        glb = Glb(path)
        os.remove(path)
        meshes = glb.json.pop("meshes", [])
        worn = {n["name"]: meshes[n["mesh"]]["primitives"][0].get("material") for n in glb.json.pop("nodes", []) if "mesh" in n}
        materials.restore_names(glb, self.original_names)
        materials.complete(glb)
        return glb, worn


    def _blame(self, path):
        """Finds the material at which the exporter fails, and an object that uses it."""
        placed = list(self._wearers)
        for one in placed:
            self.scene.collection.objects.unlink(one)
        for one in placed:
            self.scene.collection.objects.link(one)
            try:
                _export(self, path)
            except _ExporterFailed:
                material, wearer = self._wearers[one]
                return f" at the material '{material}' of '{wearer}'"
            self.scene.collection.objects.unlink(one)
        return ""


class _ExporterFailed(Exception):
    """The message is one line."""


class _Context:
    """Blender's context without its window. The exporter would switch the window to the exported scene, which
    the user would see and which makes Blender evaluate the user's scene twice more."""

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
        raise Refused("Emberline: the glTF exporter is off; enable the add-on 'glTF 2.0 format' in Preferences > Add-ons") from None
    override = {"scene": scratch.scene, "view_layer": scratch.scene.view_layers[0], "selected_objects": []}
    context = bpy.context
    with context.temp_override(**override, active_object=None, object=None):
        bpy.context = _Context(context)
        try:
            with _operator_fault() as fault:
                operator(**{name: value for name, value in wanted.items() if name in known})
        except RuntimeError as error:
            raise _ExporterFailed(_one_line(fault.get("raised", error))) from error
        finally:
            bpy.context = context


@contextlib.contextmanager
def _operator_fault():
    """Captures the exporter's exception: Blender passes it on only as truncated traceback text."""
    kind, fault = bpy.types.EXPORT_SCENE_OT_gltf, {}
    execute = kind.execute

    def noting(self, context):
        try:
            return execute(self, context)
        except Exception as error:
            fault["raised"] = error
            raise

    had, own = "execute" in vars(kind), vars(kind).get("execute")
    kind.execute = noting
    try:
        yield fault
    finally:
        if had:
            kind.execute = own
        else:
            del kind.execute


def _one_line(error):
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and not line.startswith("Location:")]
    return f"{type(error).__name__}: {'; '.join(lines[:3])}" if lines else type(error).__name__


class Parts:
    """Meshes and materials of an exported file, for reuse: the file's index of each mesh, and where they end."""

    def __init__(self):
        self.path, self.meshes, self.end = "", {}, None


def worn_by(placed):
    """Names of the materials in the object's slots."""
    return tuple(slot.material.name_full if slot.material else "" for slot in placed.material_slots)


# A mesh or a light. `track`: matrices per moment; `key`: of its mesh; `holdout`: it is a hole to the camera.
_Thing = collections.namedtuple("_Thing", "name data track group key unseen holdout", defaults=(None, False, False))


class Export:
    """Writes scene.glb to `folder` from the depsgraph.

    `groups` then maps light layers to Blender's light groups, for those in `light_groups`. `holdout` is the name of the
    parent node of all holdouts, or None.

    `parts`: an earlier export whose meshes and materials are still valid; only nodes are then written, unless a mesh is
    missing. `shutter` (motion.py): evaluate the scene at each of its moments; `view` is then that of the middle, and
    `moves` says whether anything moves. `only`: names of the objects to export, with their instances."""

    def __init__(self, depsgraph, folder, light_groups=(), parts=None, shutter=None, only=None):
        self._depsgraph = depsgraph
        self._light_groups = set(light_groups)
        self._shutter, self._only = shutter, only
        self.view, self.groups, self.said = None, {}, []
        self.path = os.path.join(folder, "scene.glb")
        if parts and self._gather(parts.meshes):
            glb = Glb(parts.path)
            glb.cut(parts.end)
        else:
            parts, glb = self._export_parts(folder)
        self._place(glb, parts)
        glb.write(self.path)
        parts.path = self.path
        self.parts = parts

    def lights(self):
        """Object name and light data of each light."""
        return [(thing.name, thing.data) for thing in self._things.values() if not thing.key]

    def _export_parts(self, folder):
        parts, read, self._views = Parts(), {}, {}
        with _Scratch(self._depsgraph) as scratch:
            if self._shutter:
                for moment in self._shutter.moments():
                    self._views[moment] = camera.view(self._depsgraph)
                    if moment == self._shutter.middle:
                        self._gather(read, scratch)
                    else:
                        self._follow(moment, read)
                self.view = self._views[self._shutter.middle]
            else:
                self._gather(read, scratch)
            self.said += scratch.said
            glb, worn = scratch.export(folder)
        for key, mesh in read.items():
            parts.meshes[key] = mesh and mesh.add_to(glb, worn)
        parts.end = glb.end()
        return parts, glb

    def _instances(self):
        """Yields what is rendered: a name that is stable over time, the object, its owner, and its matrix."""
        for instance in self._depsgraph.object_instances:
            placed = instance.object
            if instance.show_self and (placed.type == "LIGHT" or placed.type in _MESHES and placed.data):
                name = placed.name_full
                owner = instance.parent if instance.is_instance else placed
                if self._only is not None and owner.name_full not in self._only:
                    continue
                if instance.is_instance:
                    name = (name, owner.name_full, *instance.persistent_id)
                yield name, placed, owner, instance.matrix_world.copy()

    def _gather(self, meshes, scratch=None):
        """Lists the objects to export and reads new meshes into `meshes`; without `scratch`, returns False instead."""
        self._things, self.worn = {}, {}
        self._low, self._high = Vector((1e30,) * 3), Vector((-1e30,) * 3)
        scene = self._depsgraph.scene_eval
        seen_by = scene.camera.evaluated_get(self._depsgraph) if scene.camera else None
        moments = len(self._shutter.times) if self._shutter else 1
        for name, placed, owner, world in self._instances():
            group = getattr(placed, "lightgroup", "")
            group = group if group in self._light_groups else ""
            track = [world] * moments
            if placed.type == "LIGHT":
                unseen = not placed.visible_camera and lights.in_view(scene, seen_by, placed.data, world)
                self._things[name] = _Thing(placed.name, placed.data, track, group, unseen=unseen)
                continue
            worn = self.worn[placed.name_full] = worn_by(placed)
            # Objects without modifiers share their data; evaluated data of others have separate addresses.
            key = (placed.data.as_pointer(), placed.type, worn)
            if placed.type != "MESH":
                key = (placed.original.as_pointer(), placed.type, worn)
            if key not in meshes:
                if not scratch:
                    return False
                meshes[key] = self._read(name, placed, scratch)
            if meshes[key] is None:
                continue
            holdout = owner.holdout_get(view_layer=self._depsgraph.view_layer_eval)
            self._things[name] = _Thing(placed.name, placed.data, track, group, key, holdout=holdout)
            for corner in placed.bound_box:
                at = world @ Vector(corner)
                self._low = Vector(map(min, self._low, at))
                self._high = Vector(map(max, self._high, at))
        return True

    @staticmethod
    def _read(name, placed, scratch):
        """Reads a mesh; None if it has no faces."""
        try:
            mesh = placed.to_mesh()
        except RuntimeError:
            return None  # a type without a mesh; limits.py lists it
        try:
            if not mesh or not mesh.polygons:
                return None
            worn = [slot.material for slot in placed.material_slots]
            worn += list(mesh.materials)[len(worn) :]
            uv_maps = tuple(layer.name for layer in mesh.uv_layers)
            shown = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
            read = Mesh(mesh, name)
            if not read.finite:
                raise Refused(f"Emberline: '{placed.name}' has vertices with coordinates that are not numbers")
            for slot in read.slots:
                if slot < len(worn) and worn[slot]:
                    read.worn[slot] = scratch.triangle(worn[slot], uv_maps, shown, placed.name)
            return read
        finally:
            placed.to_mesh_clear()

    def _follow(self, moment, meshes):
        """Records transforms and changed shapes at another moment."""
        changed = {update.id.original for update in self._depsgraph.updates if update.is_updated_geometry}
        for name, placed, _, world in self._instances():
            thing = self._things.get(name)
            if not thing:
                continue
            thing.track[moment] = world
            mesh = meshes.get(thing.key)
            if mesh and mesh.of == name and placed.original in changed:
                line = f"{thing.name}: the faces change while the shutter is open; the change of shape is not blurred"
                if not mesh.add_pose(placed.to_mesh()) and line not in self.said:
                    self.said.append(line)
                placed.to_mesh_clear()

    @staticmethod
    def _above(glb, nodes):
        """Adds a parent node for `nodes` and returns its unique name."""
        name, taken = "holdouts", {node.get("name") for node in glb.json["nodes"]}
        while name in taken:
            name += "_"
        glb.add("nodes", {"name": name, "children": nodes})
        return name

    def _place(self, glb, parts):
        animation = Animation(glb, self._shutter.times if self._shutter else ())
        placed, holes, split = [], [], materials.LightGroups(glb)
        centre = (self._low + self._high) / 2 if self._low.x <= self._high.x else Vector((0, 0, 0))
        radius = max((self._high - self._low).length / 2, 1e-6) if self._low.x <= self._high.x else 1.0
        light_layers = {}
        for index, thing in enumerate(self._things.values()):
            if thing.key:
                mesh = parts.meshes[thing.key]
                morphs = len(glb.json["meshes"][mesh].get("weights", ()))
                node = animation.node(thing.track, morphs, name=thing.name, mesh=split.mesh(mesh, thing.group))
                (holes if thing.holdout else placed).append(node)
                continue
            # Light groups are found by the layer's name, which two lights might share.
            layer = f"group{index}-{thing.name}" if thing.group else thing.name
            if thing.group:
                light_layers[layer] = thing.group
            placed.append(lights.add(glb, animation, layer, thing.data, thing.track, centre, radius, thing.unseen))
        placed, holes = ([node for node in nodes if node is not None] for nodes in (placed, holes))
        self.holdout = self._above(glb, holes) if holes else None
        placed += [len(glb.json["nodes"]) - 1] if holes else []
        if not placed:
            self.said.append("the scene has no mesh and no light; only the world is rendered")
        if self.view:
            placed += self.view.follow(glb, animation, [self._views[i] for i in sorted(self._views)])
        glb.json["scene"], glb.json["scenes"] = 0, [{"nodes": placed} if placed else {}]
        split.name_emitters()
        self.groups = {**split.layers, **light_layers}
        self.moves = not animation.empty
