"""The render engine: exports the scene, runs `emberline render`, shows the progress and returns the passes."""
import json
import os
import queue
import shutil
import threading
import time
import traceback
from concurrent import futures

import bpy

from . import camera, command, exr, guard, limits, motion, passes, settings, versions, viewport, world
from .command import EmberlineError
from .scene_export import Export

_POLL_SECONDS = 0.1  # seconds between two checks for Esc
_UPDATE_SECONDS = 0.25  # seconds between two picture updates


class _Cancelled(Exception):
    pass


# Blender renders on a separate thread, but only the main thread may change its data. A timer on the main thread runs
# these jobs.
_main_thread_jobs = queue.SimpleQueue()


def _do_main_thread_jobs():
    while not _main_thread_jobs.empty():
        _main_thread_jobs.get()()
    return 0.05


def _on_main_thread(engine, function):
    if threading.current_thread() is threading.main_thread():
        return function()
    future = futures.Future()

    def job():
        if not future.set_running_or_notify_cancel():
            return
        try:
            future.set_result(function())
        except BaseException as error:  # passes it on to the waiting thread
            future.set_exception(error)

    _main_thread_jobs.put(job)
    while not futures.wait((future,), _POLL_SECONDS).done:
        if engine.test_break():
            future.cancel()
            raise _Cancelled
    return future.result()


class EmberlineRenderEngine(bpy.types.RenderEngine):
    bl_idname = "EMBERLINE"
    bl_label = "Emberline"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    bl_use_postprocess = True

    _viewport = None

    def view_update(self, context, depsgraph):
        if not self._viewport:
            self._viewport = viewport.Viewport(self, context, depsgraph)
        self._viewport.changed(depsgraph)

    def view_draw(self, context, depsgraph):
        if self._viewport:
            self._viewport.draw(self, context, depsgraph)

    def __del__(self):
        try:
            if self._viewport:
                self._viewport.close()
        except ReferenceError:
            pass  # newer Blender versions have freed the engine by now; viewport.py notices this itself

    def update_render_passes(self, scene, renderlayer):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for name, channels, kind in passes.requested_passes(scene, renderlayer):
            self.register_pass(scene, renderlayer, name, len(channels), channels, kind)

    def render(self, depsgraph):
        folder = guard.folder()
        try:
            self._render(depsgraph, folder)
        except _Cancelled:
            pass
        except (EmberlineError, exr.ExrError, OSError) as fault:
            self._fail(str(fault))
        except Exception as fault:  # a bug in the add-on, or a missing EXR layer: say why the frame is empty
            traceback.print_exc()
            self._fail(f"Emberline: internal error in the add-on: {type(fault).__name__}: {fault}")
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def _fail(self, line):
        self.report({"ERROR"}, line)
        if not versions.REPORT_SHOWS_ERRORS:
            self.error_set(line)

    def _render(self, depsgraph, folder):
        scene, layer = depsgraph.scene, depsgraph.view_layer
        if scene.render.use_multiview:
            raise EmberlineError("Emberline: stereo is not supported; turn off Output Properties > Stereoscopy")
        program = command.find(settings.preferred_command())
        view = camera.view(depsgraph)
        for name, line in limits.missing_libraries():
            self.report({"WARNING"}, f"Emberline: {name}: {line}")
        self.update_stats("", "Emberline: exporting the scene")

        def export():
            shutter = motion.Shutter(self, scene) if scene.render.use_motion_blur else None
            exported = Export(depsgraph, folder, passes.light_groups(layer), shutter=shutter)
            versions.update_after_export(depsgraph)
            return exported, world.options(depsgraph.scene_eval.world, folder)

        exported, light = _on_main_thread(self, export)
        for line in exported.warnings:
            self.report({"WARNING"}, f"Emberline: {line}")
        view = exported.view or view
        groups = dict(exported.groups)
        if scene.world and getattr(scene.world, "lightgroup", ""):
            groups["environment"] = scene.world.lightgroup
        with open(os.path.join(folder, "edits.json"), "w", encoding="utf-8") as file:
            json.dump({"emberline_edits": 1, "camera": view.edit}, file)

        frame, report = os.path.join(folder, "frame.exr"), os.path.join(folder, "report.json")
        viewer = command.Viewer(view.width, view.height)
        arguments = [program, "render", exported.path, "-o", frame, "--exr-compression", "none", "--report", report]
        arguments += ["--edits", os.path.join(folder, "edits.json"), "--display", viewer.url]
        arguments += ["--size", f"{view.width}x{view.height}", "--crop", ",".join(map(str, view.crop))]
        arguments += light + settings.options(scene) + passes.options(scene, layer)
        arguments += motion.OPTIONS if exported.moves else []
        arguments += ["--holdout", exported.holdout] if exported.holdout else []
        try:
            self._wait_for_frame(command.Process(arguments, folder), viewer, view.crop, layer)
        finally:
            viewer.close()
        self._finish(frame, report, groups, scene, layer)

    def _result(self, layer, crop):
        return self.begin_result(0, 0, crop[2] - crop[0], crop[3] - crop[1], layer=layer.name)

    def _wait_for_frame(self, process, viewer, crop, layer):
        """Waits until the frame ends. Esc kills the process; its files are removed later, together with our folder."""
        shown = time.monotonic()
        result = self._result(layer, crop)
        code = None
        try:
            while code is None:
                code = process.wait(_POLL_SECONDS)
                if self.test_break():
                    raise _Cancelled
                if time.monotonic() - shown >= _UPDATE_SECONDS:
                    self._show_picture(viewer.take(), result, crop)
                    self._show_progress(process.progress())
                    shown = time.monotonic()
        finally:
            if code is None:
                process.kill()
            self.end_result(result, cancel=code != 0)
        if code != 0:
            raise EmberlineError(process.fault(code))

    def _show_picture(self, picture, result, crop):
        if picture is None:
            return
        x0, y0, x1, y1 = crop
        part = picture[y0:y1, x0:x1]
        passes.fill(result.layers[0], "Combined", [part[:, :, c] for c in range(4)])
        self.update_result(result)

    def _show_progress(self, progress):
        done = progress.get("done") or 0.0
        self.update_progress(min(max(done, 0.0), 1.0))
        left = progress.get("left_s")
        text = f"Emberline: {100 * done:.0f} %"
        if left is not None:
            text += f" | Remaining: {int(left) // 60:02}:{int(left) % 60:02}"
        self.update_stats("", text)

    def _finish(self, frame, report, groups, scene, layer):
        planes, texts = exr.read(frame)
        height, width = planes["R"].shape
        result = self._result(layer, (0, 0, width, height))
        passes.put(result.layers[0], scene, layer, planes, groups)
        self.end_result(result)
        passes.store_cryptomatte_names(self.get_result(), layer, texts)
        limits.store_report_warnings(scene, report)
        try:
            shutil.move(frame, guard.last_frame())
        except OSError:
            pass  # then there are no heatmaps


def register():
    bpy.utils.register_class(EmberlineRenderEngine)
    if not bpy.app.background:
        bpy.app.timers.register(_do_main_thread_jobs, persistent=True)
    viewport.register()


def unregister():
    viewport.unregister()
    if bpy.app.timers.is_registered(_do_main_thread_jobs):
        bpy.app.timers.unregister(_do_main_thread_jobs)
    guard.stop()
    bpy.utils.unregister_class(EmberlineRenderEngine)
