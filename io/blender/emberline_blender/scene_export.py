"""Exports the evaluated scene as a .glb for Emberline.

Blender's own exporter writes the materials. It exports a temporary scene with one triangle per material, so that the
user's scene is not touched. To the exporter's file, this module adds each mesh once, the nodes and the lights.
"""
import collections
import contextlib
import os
import types

import bpy
from mathutils import Vector

from . import camera, images, lights, materials
from .command import EmberlineError
from .glb import Glb
from .meshes import Mesh
from .motion import Animation

_MESH_TYPES = ("MESH", "CURVE", "SURFACE", "FONT", "META")


class _MaterialScene:
    """A temporary scene with one triangle for each material in use, for the exporter."""

    def __init__(self, depsgraph):
        self.scene = bpy.data.scenes.new("Emberline export")
        self.ids, self.original_names, self.warnings = [], {}, []
        self._copies = materials.Copies(depsgraph, self.ids, self.original_names)
        self._triangles, self._users = {}, {}  # triangle names, by material; (material, user) names, by triangle

    def __enter__(self):
        return self

    def __exit__(self, *_):
        bpy.data.scenes.remove(self.scene)
        bpy.data.batch_remove(self.ids)

    def triangle(self, material, uv_maps, active_uv_map, user):
        """Returns the name of the material's triangle. `user` is the name of an object that has the material. Textures
        refer to UV maps, so meshes with different UV maps need separate triangles."""
        used_materials = (self._copies.of(material), uv_maps, active_uv_map)
        if used_materials not in self._triangles:
            mesh = bpy.data.meshes.new("emberline")
            placed = bpy.data.objects.new(f"emberline {len(self._triangles)}", mesh)
            self.ids += [placed, mesh]
            mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
            mesh.materials.append(used_materials[0])
            for name in uv_maps:
                mesh.uv_layers.new(name=name).active_render = name == active_uv_map
            self.scene.collection.objects.link(placed)
            self._triangles[used_materials] = placed.name
            self._users[placed] = (material.name, user)
            for node in materials.image_nodes(material.original):
                if node.image.source == "TILED":
                    self.warnings += [f"{user}: {material.name}: {line}" for line in images.differences(node.image)]
        return self._triangles[used_materials]

    def export(self, folder):
        """Runs the exporter. Returns the file that it wrote, and the material index of each triangle."""
        if not self._triangles:
            return Glb(), {}
        path = os.path.join(folder, "materials.glb")
        try:
            _export(self, path)
        except _ExporterFailed as fault:
            raise EmberlineError(f"Emberline: Blender's glTF exporter failed{self._find_failing_material(path)}: {fault}") from fault
        glb = Glb(path)
        os.remove(path)
        meshes = glb.json.pop("meshes", [])
        used_materials = {n["name"]: meshes[n["mesh"]]["primitives"][0].get("material") for n in glb.json.pop("nodes", []) if "mesh" in n}
        materials.restore_names(glb, self.original_names)
        materials.complete(glb)
        return glb, used_materials


    def _find_failing_material(self, path):
        """Finds the material at which the exporter fails. Returns text that names the material and one of its users."""
        placed = list(self._users)
        for one in placed:
            self.scene.collection.objects.unlink(one)
        for one in placed:
            self.scene.collection.objects.link(one)
            try:
                _export(self, path)
            except _ExporterFailed:
                material, user = self._users[one]
                return f" at the material '{material}' of '{user}'"
            self.scene.collection.objects.unlink(one)
        return ""


class _ExporterFailed(Exception):
    """Raised if Blender's exporter fails. The message is one line."""


class _Context:
    """Blender's context without its window. With the window, the exporter would switch it to the exported scene. The
    user would see this, and Blender would evaluate the user's scene twice more."""

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
        raise EmberlineError("Emberline: the glTF exporter is disabled; enable the add-on 'glTF 2.0 format' in Preferences > Add-ons") from None
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
    """Captures the exporter's exception, which Blender passes on only as the text of a truncated traceback."""
    kind, fault = bpy.types.EXPORT_SCENE_OT_gltf, {}
    execute = kind.execute

    def recording_execute(self, context):
        try:
            return execute(self, context)
        except Exception as error:
            fault["raised"] = error
            raise

    had_execute, own = "execute" in vars(kind), vars(kind).get("execute")
    kind.execute = recording_execute
    try:
        yield fault
    finally:
        if had_execute:
            kind.execute = own
        else:
            del kind.execute


def _one_line(error):
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and not line.startswith("Location:")]
    return f"{type(error).__name__}: {'; '.join(lines[:3])}" if lines else type(error).__name__


class Parts:
    """The meshes and materials of an exported file, for reuse. `meshes` maps the key of each mesh to its index in the
    file. `end` says where these parts end in the file."""

    def __init__(self):
        self.path, self.meshes, self.end = "", {}, None


def material_names(placed):
    """Returns the names of the materials in the object's slots."""
    return tuple(slot.material.name_full if slot.material else "" for slot in placed.material_slots)


# A mesh or a light. `track` has a matrix per moment, `key` identifies a mesh, and a `holdout` is a hole in the picture.
_ExportItem = collections.namedtuple("_ExportItem", "name data track group key hidden_from_camera holdout", defaults=(None, False, False))


class Export:
    """Writes scene.glb to `folder` from the depsgraph.

    Afterwards, the attribute `groups` maps light layers to Blender's light groups, but only to those in `light_groups`.
    The attribute `holdout` is the name of the parent node of all holdouts, or None.

    `parts` come from an earlier export whose meshes and materials are still valid. With them, only nodes are written,
    unless a mesh is missing. With a `shutter` (motion.py), the scene is evaluated at each of the shutter's moments. The
    attribute `view` is then the view at the middle moment, and `moves` says whether anything moves. `only`, if given,
    names the objects to export; their instances are exported too."""

    def __init__(self, depsgraph, folder, light_groups=(), parts=None, shutter=None, only=None):
        self._depsgraph = depsgraph
        self._light_groups = set(light_groups)
        self._shutter, self._visible_names = shutter, only
        self.view, self.groups, self.warnings = None, {}, []
        self.path = os.path.join(folder, "scene.glb")
        if parts and self._collect(parts.meshes):
            glb = Glb(parts.path)
            glb.truncate(parts.end)
        else:
            parts, glb = self._export_parts(folder)
        self._place(glb, parts)
        glb.write(self.path)
        parts.path = self.path
        self.parts = parts

    def lights(self):
        """Returns the object name and the light data of each light."""
        return [(item.name, item.data) for item in self._items.values() if not item.key]

    def _export_parts(self, folder):
        parts, read, self._views = Parts(), {}, {}
        with _MaterialScene(self._depsgraph) as scratch:
            if self._shutter:
                for moment in self._shutter.moments():
                    self._views[moment] = camera.view(self._depsgraph)
                    if moment == self._shutter.middle:
                        self._collect(read, scratch)
                    else:
                        self._record_moment(moment, read)
                self.view = self._views[self._shutter.middle]
            else:
                self._collect(read, scratch)
            self.warnings += scratch.warnings
            glb, used_materials = scratch.export(folder)
        for key, mesh in read.items():
            parts.meshes[key] = mesh and mesh.add_to(glb, used_materials)
        parts.end = glb.end()
        return parts, glb

    def _instances(self):
        """Yields what is rendered: a name that does not change over time, the object, its owner, and its matrix."""
        for instance in self._depsgraph.object_instances:
            placed = instance.object
            if instance.show_self and (placed.type == "LIGHT" or placed.type in _MESH_TYPES and placed.data):
                name = placed.name_full
                owner = instance.parent if instance.is_instance else placed
                if self._visible_names is not None and owner.name_full not in self._visible_names:
                    continue
                if instance.is_instance:
                    name = (name, owner.name_full, *instance.persistent_id)
                yield name, placed, owner, instance.matrix_world.copy()

    def _collect(self, meshes, scratch=None):
        """Lists the objects to export and reads new meshes into `meshes`. Returns False if there is a new mesh but no
        `scratch`."""
        self._items, self.used_materials = {}, {}
        self._low, self._high = Vector((1e30,) * 3), Vector((-1e30,) * 3)
        scene = self._depsgraph.scene_eval
        seen_by = scene.camera.evaluated_get(self._depsgraph) if scene.camera else None
        moments = len(self._shutter.times) if self._shutter else 1
        for name, placed, owner, world in self._instances():
            group = getattr(placed, "lightgroup", "")
            group = group if group in self._light_groups else ""
            track = [world] * moments
            if placed.type == "LIGHT":
                hidden_from_camera = not placed.visible_camera and lights.in_view(scene, seen_by, placed.data, world)
                self._items[name] = _ExportItem(placed.name, placed.data, track, group, hidden_from_camera=hidden_from_camera)
                continue
            used_materials = self.used_materials[placed.name_full] = material_names(placed)
            # Objects without modifiers share their data. An object with modifiers has evaluated data at a separate
            # address.
            key = (placed.data.as_pointer(), placed.type, used_materials)
            if placed.type != "MESH":
                key = (placed.original.as_pointer(), placed.type, used_materials)
            if key not in meshes:
                if not scratch:
                    return False
                meshes[key] = self._read(name, placed, scratch)
            if meshes[key] is None:
                continue
            holdout = owner.holdout_get(view_layer=self._depsgraph.view_layer_eval)
            self._items[name] = _ExportItem(placed.name, placed.data, track, group, key, holdout=holdout)
            for corner in placed.bound_box:
                at = world @ Vector(corner)
                self._low = Vector(map(min, self._low, at))
                self._high = Vector(map(max, self._high, at))
        return True

    @staticmethod
    def _read(name, placed, scratch):
        """Reads a mesh. Returns None if it has no faces."""
        try:
            mesh = placed.to_mesh()
        except RuntimeError:
            return None  # a type without a mesh; limits.py lists it
        try:
            if not mesh or not mesh.polygons:
                return None
            used_materials = [slot.material for slot in placed.material_slots]
            used_materials += list(mesh.materials)[len(used_materials) :]
            uv_maps = tuple(layer.name for layer in mesh.uv_layers)
            shown = next((layer.name for layer in mesh.uv_layers if layer.active_render), "")
            read = Mesh(mesh, name)
            if not read.finite:
                raise EmberlineError(f"Emberline: '{placed.name}' has vertices with NaN or infinite coordinates")
            for slot in read.slots:
                if slot < len(used_materials) and used_materials[slot]:
                    read.used_materials[slot] = scratch.triangle(used_materials[slot], uv_maps, shown, placed.name)
            return read
        finally:
            placed.to_mesh_clear()

    def _record_moment(self, moment, meshes):
        """Records transforms and changed shapes at another moment."""
        changed = {update.id.original for update in self._depsgraph.updates if update.is_updated_geometry}
        for name, placed, _, world in self._instances():
            item = self._items.get(name)
            if not item:
                continue
            item.track[moment] = world
            mesh = meshes.get(item.key)
            if mesh and mesh.of == name and placed.original in changed:
                line = f"{item.name}: the topology changes while the shutter is open, so the change of shape is not blurred"
                if not mesh.add_pose(placed.to_mesh()) and line not in self.warnings:
                    self.warnings.append(line)
                placed.to_mesh_clear()

    @staticmethod
    def _add_parent(glb, nodes):
        """Adds a parent node for `nodes` and returns its unique name."""
        name, taken = "holdouts", {node.get("name") for node in glb.json["nodes"]}
        while name in taken:
            name += "_"
        glb.add("nodes", {"name": name, "children": nodes})
        return name

    def _place(self, glb, parts):
        animation = Animation(glb, self._shutter.times if self._shutter else ())
        placed, holdout_nodes, split = [], [], materials.LightGroups(glb)
        centre = (self._low + self._high) / 2 if self._low.x <= self._high.x else Vector((0, 0, 0))
        radius = max((self._high - self._low).length / 2, 1e-6) if self._low.x <= self._high.x else 1.0
        light_layers = {}
        for index, item in enumerate(self._items.values()):
            if item.key:
                mesh = parts.meshes[item.key]
                morphs = len(glb.json["meshes"][mesh].get("weights", ()))
                node = animation.node(item.track, morphs, name=item.name, mesh=split.mesh(mesh, item.group))
                (holdout_nodes if item.holdout else placed).append(node)
                continue
            # Light groups are found by the layer's name. The index keeps two lights from having the same layer name.
            layer = f"group{index}-{item.name}" if item.group else item.name
            if item.group:
                light_layers[layer] = item.group
            placed.append(lights.add(glb, animation, layer, item.data, item.track, centre, radius, item.hidden_from_camera))
        placed, holdout_nodes = ([node for node in nodes if node is not None] for nodes in (placed, holdout_nodes))
        self.holdout = self._add_parent(glb, holdout_nodes) if holdout_nodes else None
        placed += [len(glb.json["nodes"]) - 1] if holdout_nodes else []
        if not placed:
            self.warnings.append("the scene has no mesh and no light; only the world is rendered")
        if self.view:
            placed += self.view.animate(glb, animation, [self._views[i] for i in sorted(self._views)])
        glb.json["scene"], glb.json["scenes"] = 0, [{"nodes": placed} if placed else {}]
        split.name_emitters()
        self.groups = {**split.layers, **light_layers}
        self.moves = not animation.empty
