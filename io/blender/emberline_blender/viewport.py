"""Shows the image in a viewport: sends changes to `emberline session` and draws its pictures.

A new view is sent at once, whenever Blender draws. Other changes wait for a timer, because only a timer may create data
for the export. The world, plain materials, and a light's colour and power are sent as edits. Moved objects and lights
are written again, but reuse the meshes of the last export. For any other change, the whole scene is exported again. The
old picture stays until the next one arrives.
"""
import os
import shutil
import time
import traceback
import weakref

import bpy
import gpu
from gpu_extras.presets import draw_texture_2d

from . import camera, command, guard, live_edits, settings, world
from .command import EmberlineError
from .scene_export import Export, material_names
from .session import Session

_POLL_SECONDS = 1 / 60  # seconds between two checks for pictures and changes
_NOTHING, _TRANSFORMS, _ALL = range(3)  # how much must be exported again

_viewports = set()
_exporting = False


class _Changes:
    """Pending changes. `extent` says what must be exported again. If `extent` is _NOTHING, edits to the world and to
    the named materials and lights are enough."""

    def __init__(self, extent):
        self.extent, self.materials, self.lights, self.world = extent, set(), set(), False

    def __bool__(self):
        return bool(self.extent or self.materials or self.lights or self.world)

    def add(self, update):
        data = update.id
        kind = data.bl_rna.identifier
        if kind in ("Scene", "Camera", "Screen", "WindowManager", "Collection", "ViewLayer") or data.is_embedded_data:
            return  # changed() counts objects and _send() compares views; Blender also reports an embedded tree's owner
        if kind == "Material":
            self.materials.add(data.name_full)
        elif isinstance(data, bpy.types.Light):
            self.lights.add(data.name_full)
        elif kind == "World":
            self.world = True
        elif kind != "Object":
            self.extent = _ALL
        elif data.type == "LIGHT":
            self.extent = max(self.extent, _TRANSFORMS if update.is_updated_transform else _NOTHING)
        elif data.type == "EMPTY" or not (update.is_updated_geometry or update.is_updated_shading):
            self.extent = max(self.extent, _TRANSFORMS if data.type != "CAMERA" else _NOTHING)
        elif data.type != "CAMERA":
            self.extent = _ALL


def _as_settings(arguments):
    """Converts command-line options to a session's settings."""
    named, last = {}, None
    for argument in arguments:
        if argument.startswith("--"):
            last = argument[2:]
            named[last] = True
        else:
            named[last] = argument
    return named


class Viewport:
    def __init__(self, engine, context, depsgraph):
        self._engine = weakref.ref(engine)
        self._scene, self._layer = depsgraph.scene.name, depsgraph.view_layer.name
        self._folder = guard.folder()
        self._session = None
        self._changes, self._objects = _Changes(_ALL), -1
        self._materials, self._lights = {}, {}  # states at the last export, see live_edits.py
        self._edits = {"materials": {}, "lights": {}}  # edits since the last export, by name
        self._scene_names = {}  # names in the open scene
        self._parts = None  # parts of the last export, for reuse
        self._material_names = {}  # material names by object
        self._worlds = 0  # number of worlds sent
        self._visible_names = None  # the objects visible in local view, or None
        self._view, self._settings = None, {}
        self._requested_id = self._open_id = 0  # ids of `open` commands
        self._picture, self._texture = None, None
        self._status, self._drawn_status, self._next_export_time = None, None, 0.0
        try:
            self._session = Session(command.find(settings.preferred_command()), os.path.join(self._folder, "log.txt"))
            self._status = "Emberline: exporting the scene"
        except EmberlineError as fault:
            self._status = str(fault)
        _viewports.add(self)

    def close(self):
        _viewports.discard(self)
        if self._session:
            self._session.close()
        self._session = self._texture = None
        shutil.rmtree(self._folder, ignore_errors=True)

    def changed(self, depsgraph):
        if _exporting:
            return
        updates = list(depsgraph.updates)
        materials = any(isinstance(update.id, bpy.types.Material) for update in updates)
        for update in updates:
            if not (materials and self._is_material_update(update)):
                self._changes.add(update)
        count = len(depsgraph.objects)
        if count != self._objects:
            self._changes.extent, self._objects = _ALL, count

    def _is_material_update(self, update):
        """Whether the update lists the object only because one of its materials changed. Blender 4 does this."""
        data = update.id
        if update.is_updated_geometry or update.is_updated_transform:
            return False
        if isinstance(data, bpy.types.Object) and data.type != "LIGHT":
            return material_names(data) == self._material_names.get(data.name_full)
        return isinstance(data, bpy.types.Mesh)

    # Called by a timer on the main thread.
    def step(self):
        engine = self._engine()
        if not engine:
            raise ReferenceError
        engine.is_preview  # raises if Blender has freed the engine; the Python object may live longer
        if not self._session:
            return
        if self._session.fault:
            self._status = f"Emberline: {self._session.fault}"
            self._session = None
            engine.tag_redraw()
            return
        for answer in self._session.take_answers():
            self._handle_answer(answer)
        if self._changes and self._view and not bpy.app.is_job_running("RENDER"):
            if not self._changes.extent and self._open_id == self._requested_id and not self._edit():
                self._changes.extent = _ALL
            if self._changes.extent and time.monotonic() >= self._next_export_time:
                began = time.monotonic()
                self._export()
                # If changes are continuous, this leaves half of the time to Blender.
                self._next_export_time = 2 * time.monotonic() - began
                if not self._session:
                    engine.tag_redraw()
                    return
        if self._session.problem:
            self._status = f"Emberline: {self._session.problem}"
        picture = self._session.take_picture()
        # Redraw only when needed, because a redraw takes CPU time that the session needs for loading.
        if picture or self._status != self._drawn_status:
            self._picture = picture or self._picture
            self._drawn_status = self._status
            engine.tag_redraw()

    def _handle_answer(self, answer):
        if not answer["ok"]:
            self._status = f"Emberline: {answer.get('error', 'the session refused a command')}"
        if answer.get("id") == self._requested_id:
            self._open_id = self._requested_id
            if answer["ok"]:
                self._status = None
                self._scene_names = answer["scene"]
                # The view may have changed since `open`.
                self._session.send_command("camera", camera=self._view.edit)

    def _edit(self):
        """Sends the changes as edits. Returns False if edits are not enough."""
        changes, edits = self._changes, {"materials": [], "lights": []}
        for name in changes.materials:
            material = bpy.data.materials.get(name)
            now, before = material and live_edits.material_state(material), self._materials.get(name)
            if not now or not before or now[0] != before[0] or self._scene_names.get("materials", []).count(name) != 1:
                return False
            edits["materials"].append({"name": name, **now[1]})
        for name, (data, before) in self._lights.items():
            if data not in changes.lights:
                continue
            light = bpy.data.lights.get(data)
            now = live_edits.light_state(light) if light else None
            edit = live_edits.light_edit(before[1], now[1]) if now and now[0] == before[0] else None
            kind = "punctual" if name in self._scene_names.get("lights", []) else "material"
            if not edit or self._scene_names.get("lights" if kind == "punctual" else "materials", []).count(name) != 1:
                return False
            edits["lights"].append({"kind": kind, "name": name, **edit})
        if changes.world:
            self._send_world()
        changed = {part: entries for part, entries in edits.items() if entries}
        for part, entries in changed.items():
            self._edits[part].update({entry["name"]: entry for entry in entries})
        if changed:
            self._session.send_command("edits", edits=changed)
        self._changes = _Changes(_NOTHING)
        return True

    def _send_world(self):
        """Sends the world as an edit for the open scene and as settings for later scenes."""
        # Two folders are used in turn, since the session may still be reading from the previous one.
        folder = os.path.join(self._folder, f"world {self._worlds % 2}")
        self._worlds += 1
        os.makedirs(folder, exist_ok=True)
        light = _as_settings(world.options(self._find_layer().depsgraph.scene_eval.world, folder))
        self._session.send_command("settings", settings=light)
        turn = float(light.get("env-rotation", 0))
        self._session.send_command("edits", edits={"environment": {"file": light["env"], "strength": float(light["env-strength"]), "rotation": turn}})

    def _find_layer(self):
        """Returns the view layer, or None if it has been removed."""
        scene = bpy.data.scenes.get(self._scene)
        return scene.view_layers.get(self._layer) if scene else None

    def _record_states(self, exported, again):
        """Records the exported states, for comparison with later changes."""
        self._lights = {name: (data.name_full, live_edits.light_state(data)) for name, data in exported.lights()}
        self._edits["lights"] = {}
        if again:
            states = {m.name_full: live_edits.material_state(m) for m in bpy.data.materials}
            self._materials = states
            self._edits["materials"] = {}

    def _export(self):
        """Exports the scene and opens it in the session. A failure is shown in the viewport."""
        global _exporting
        layer = self._find_layer()
        if not layer:
            return
        changes, self._changes = self._changes, _Changes(_NOTHING)
        folder = os.path.join(self._folder, str(self._requested_id + 1))
        os.makedirs(folder, exist_ok=True)
        _exporting = True
        try:
            depsgraph = layer.depsgraph
            # If materials have changed, the parts of the old file cannot be reused.
            parts = self._parts if changes.extent == _TRANSFORMS and not changes.materials else None
            exported = Export(depsgraph, folder, parts=parts, only=self._visible_names)
            self._record_states(exported, exported.parts is not parts)
            self._parts, self._material_names = exported.parts, exported.used_materials
            light = world.options(depsgraph.scene_eval.world, folder)
            layer.update()  # while _exporting is set, so that changed() ignores the temporary scene's updates
        except (EmberlineError, OSError) as fault:
            self._status = str(fault)
            return
        except Exception as fault:
            self._fail(fault)
            return
        finally:
            _exporting = False
        self._requested_id += 1
        self._session.send_command("settings", settings=_as_settings(light))
        edits = {"camera": self._view.edit, "materials": list(self._edits["materials"].values())}
        self._session.send_command("open", id=self._requested_id, scene=exported.path, edits=edits)
        self._remove_old_files()

    def _remove_old_files(self):
        """Removes the folders of all scenes that are older than the open one, except the folder whose meshes are still
        in use."""
        kept = {str(n) for n in range(self._open_id, self._requested_id + 1)}
        if self._parts:
            kept.add(os.path.basename(os.path.dirname(self._parts.path)))
        for name in os.listdir(self._folder):
            if name.isdigit() and name not in kept:
                shutil.rmtree(os.path.join(self._folder, name), ignore_errors=True)

    def _update_local_view(self, space, depsgraph):
        only = None
        if space.local_view or space.use_local_collections:
            only = {placed.name_full for placed in depsgraph.objects if placed.visible_in_viewport_get(space)}
        if only != self._visible_names:
            self._visible_names = only
            self._changes.extent = max(self._changes.extent, _TRANSFORMS)

    def _send(self, context, depsgraph):
        self._update_local_view(context.space_data, depsgraph)
        view = camera.region_view(context, depsgraph)
        wanted = _as_settings(settings.viewport_options(depsgraph.scene))
        wanted["size"] = f"{view.width}x{view.height}"
        whole = view.crop == (0, 0, view.width, view.height)
        wanted["crop"] = None if whole else ",".join(map(str, view.crop))
        changed = {name: wanted.get(name) for name in {*wanted, *self._settings} if wanted.get(name) != self._settings.get(name)}
        if changed:
            self._session.send_command("settings", settings=changed)
            self._settings = wanted
        if self._view and view.edit != self._view.edit and self._open_id:
            self._session.send_command("camera", camera=view.edit)
        self._view = view

    def _fail(self, fault):
        """Reports a bug in the add-on once and closes the session."""
        traceback.print_exc()
        self._status = f"Emberline: internal error in the add-on: {type(fault).__name__}: {fault}"
        self._picture = None
        if self._session:
            self._session.close()
            self._session = None

    def draw(self, engine, context, depsgraph):
        status = self._status
        try:
            if self._session:
                self._send(context, depsgraph)
            self._draw_picture(engine, depsgraph.scene)
        except EmberlineError as refused:
            status = str(refused)
        except Exception as fault:
            self._fail(fault)
            status = self._status
        engine.update_stats("", status or self._progress())

    def _progress(self):
        message = self._picture.message if self._picture else {}
        if not message.get("complete"):
            return ""
        area = max(message["width"] * message["height"], 1)
        return f"Emberline: {message.get('samples', 0) / area:.0f} samples" + (" | Done" if message.get("finished") else "")

    def _draw_picture(self, engine, scene):
        if self._picture is None or self._view is None:
            return
        pixels = self._picture.pixels
        if self._texture is None or self._texture[0] is not pixels:
            message = self._picture.message
            buffer = gpu.types.Buffer("FLOAT", pixels.size, pixels.ravel())
            self._texture = pixels, gpu.types.GPUTexture((message["width"], message["height"]), format="RGBA16F", data=buffer)
        view = self._view
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture[1], (view.left, view.bottom), view.crop[2] - view.crop[0], view.crop[3] - view.crop[1])
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def _step_all():
    for viewport in list(_viewports):
        try:
            viewport.step()
        except ReferenceError:  # Blender has freed the viewport's engine
            viewport.close()
        except Exception as fault:
            viewport._fail(fault)
    return _POLL_SECONDS


def register():
    if not bpy.app.background:
        bpy.app.timers.register(_step_all, persistent=True)


def unregister():
    for viewport in list(_viewports):
        viewport.close()
    if bpy.app.timers.is_registered(_step_all):
        bpy.app.timers.unregister(_step_all)
