"""Shows a heatmap of the last frame as a Blender image."""
import os
import subprocess
import tempfile

import bpy
from bpy.props import EnumProperty

from . import command, guard, settings

IMAGE = "Emberline Samples"


class EMBERLINE_OT_heatmap(bpy.types.Operator):
    bl_idname = "emberline.heatmap"
    bl_label = "Where Did the Samples Go?"
    bl_description = "Show a heatmap of the last frame as an image"

    of: EnumProperty(
        name="Show",
        description="Quantity that the heatmap shows",
        items=(
            ("samples", "Samples", "Number of samples of each pixel"),
            ("error", "Error", "Estimated RMS error of each pixel in the displayed picture"),
            ("time", "Time", "Time spent on each pixel"),
            ("stop", "Stop Reasons", "Why sampling stopped at each pixel"),
        ),
        default="samples",
    )

    @classmethod
    def poll(cls, context):
        return os.path.isfile(guard.last_frame())

    def execute(self, context):
        with tempfile.TemporaryDirectory(prefix="emberline-blender-") as folder:
            picture = os.path.join(folder, "heatmap.png")
            try:
                program = command.find(settings.preferred_command())
            except command.EmberlineError as fault:
                self.report({"ERROR"}, str(fault))
                return {"CANCELLED"}
            arguments = [program, "heatmap", guard.last_frame(), "-o", picture, "--of", self.of, "--colors", "inferno"]
            run = subprocess.run(
                arguments, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", env=command.environment()
            )
            if run.returncode:
                output_lines = (run.stderr.strip() or run.stdout.strip() or "the heatmap failed without a message").splitlines()
                self.report({"ERROR"}, f"Emberline: {output_lines[-1]}")
                return {"CANCELLED"}
            self._show(context, picture)
        return {"FINISHED"}

    def _show(self, context, picture):
        old = bpy.data.images.get(IMAGE)
        if old:
            bpy.data.images.remove(old)
        image = bpy.data.images.load(picture)
        image.name = IMAGE
        image.pack()
        image.filepath_raw = ""
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "IMAGE_EDITOR":
                    area.spaces.active.image = image
                    return
        if not bpy.app.background:
            self.report({"INFO"}, f"Open the image '{IMAGE}' in an Image Editor")


register, unregister = bpy.utils.register_classes_factory((EMBERLINE_OT_heatmap,))
