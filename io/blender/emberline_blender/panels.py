"""Defines Emberline's panels and enables the built-in panels that it shares."""
import textwrap

import bpy

from . import limits, versions

ENGINE = "EMBERLINE"
# Panels that Blender shows for all engines but that we exclude; and panels of other engines that we include.
_EXCLUDED_PANELS = {
    "VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_simplify", "DATA_PT_light", "NODE_DATA_PT_light",
    "RENDER_PT_freestyle",
}  # fmt: skip
_SHARED_PANELS = {
    "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture", "DATA_PT_EEVEE_light", "NODE_DATA_PT_EEVEE_light",
    "EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface",
    "VIEWLAYER_PT_layer_passes_cryptomatte", "VIEWLAYER_PT_layer_passes_lightgroups", "CYCLES_OBJECT_PT_lightgroup", "CYCLES_WORLD_PT_settings_light_group",
}  # fmt: skip


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def _column(self):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        return self.layout.column()


class EMBERLINE_PT_sampling(_Panel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context):
        own, column = context.scene.emberline, self._column()
        column.prop(own, "driver")
        row = column.row(heading="Noise Threshold")
        row.active = own.driver != "bisection"
        row.prop(own, "use_noise_threshold", text="")
        value = row.row()
        value.active = own.use_noise_threshold
        value.prop(own, "noise_threshold", text="")
        column.prop(own, "samples", text="Max Samples" if own.use_noise_threshold else "Samples")
        column.prop(own, "time_limit")
        column.prop(own, "viewport_samples")
        column.separator()
        column.prop(own, "use_denoising")
        row = column.row(align=True)
        row.prop(own, "seed")
        row.prop(own, "use_animated_seed", text="", icon="TIME")


class EMBERLINE_PT_where(_Panel, bpy.types.Panel):
    bl_label = "Where Did the Samples Go?"

    def draw(self, context):
        own, column = context.scene.emberline, self._column()
        column.operator("emberline.heatmap", text="Show Samples", icon="IMAGE_DATA").of = "samples"
        column.prop(own, "use_maps")
        row = column.row(align=True)
        row.enabled = own.use_maps
        for of, text in (("error", "Error"), ("time", "Time"), ("stop", "Stop Reasons")):
            row.operator("emberline.heatmap", text=text).of = of


class EMBERLINE_PT_light_paths(_Panel, bpy.types.Panel):
    bl_label = "Light Paths"

    def draw(self, context):
        own, column = context.scene.emberline, self._column()
        column.prop(own, "max_bounces")
        column.prop(own, "clamp_indirect")


class EMBERLINE_PT_motion_blur(_Panel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        render, column = context.scene.render, self._column()
        column.active = render.use_motion_blur
        column.prop(versions.shutter_owner(context.scene), "motion_blur_position", text="Position")
        column.prop(render, "motion_blur_shutter")
        column.prop(context.scene.emberline, "motion_steps", text="Steps")


class EMBERLINE_PT_film(_Panel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        own, column = context.scene.emberline, self._column()
        column.prop(own, "pixel_filter")
        if own.pixel_filter != "box":
            column.prop(own, "filter_width", text="Width")
        column.prop(context.scene.render, "film_transparent", text="Transparent")


class EMBERLINE_PT_threads(_Panel, bpy.types.Panel):
    bl_label = "Threads"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        render, column = context.scene.render, self._column()
        column.prop(render, "threads_mode")
        row = column.row()
        row.enabled = render.threads_mode == "FIXED"
        row.prop(render, "threads")


class EMBERLINE_OT_look_again(bpy.types.Operator):
    bl_idname = "emberline.look_again"
    bl_label = "Check Scene"
    bl_description = "List what Emberline renders differently from Blender"

    def execute(self, context):
        limits.look_again(context.scene)
        return {"FINISHED"}


class EMBERLINE_PT_limits(_Panel, bpy.types.Panel):
    bl_label = "Differences from Blender"

    def draw(self, context):
        column = self.layout.column(align=True)
        lines = limits.for_panel(context.scene)
        if lines is None:
            column.operator("emberline.look_again")
            lines = []
        elif not lines:
            column.label(text="No known differences", icon="CHECKMARK")
        characters = max(int(context.region.width / (8 * context.preferences.system.ui_scale)), 20)
        for name, line in lines[:50]:
            column.label(text=name, icon="ERROR")
            for part in textwrap.wrap(line[:1].upper() + line[1:], characters):
                column.label(text=part)
        if len(lines) > 50:
            column.label(text=f"And {len(lines) - 50} more")
        messages = limits.from_last_render(context.scene)
        if messages:
            column.label(text="Last render:")
        for line in messages[:20]:
            for i, part in enumerate(textwrap.wrap(line, characters)):
                column.label(text=part, icon="NONE" if i else "INFO")


class EMBERLINE_PT_passes(_Panel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layer, column = context.view_layer, self._column()
        for name, text in (
            ("use_pass_z", "Z"),
            ("use_pass_position", "Position"),
            ("use_pass_normal", "Normal"),
            ("use_pass_uv", "UV"),
            ("use_pass_diffuse_color", "Albedo"),
        ):
            column.prop(layer, name, text=text)
        column.prop(layer.emberline, "use_pass_samples")
        column.prop(layer.emberline, "use_pass_error")


# Registers the panels in the order of their definition above.
_register_classes, _unregister_classes = bpy.utils.register_classes_factory((EMBERLINE_OT_look_again, *_Panel.__subclasses__()))


def _all_panels(base=bpy.types.Panel):
    for panel in base.__subclasses__():
        yield panel
        yield from _all_panels(panel)


def _compatible_panels():
    for panel in _all_panels():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        name = panel.__name__
        if engines is not None and name not in _EXCLUDED_PANELS and ("BLENDER_RENDER" in engines or name in _SHARED_PANELS):
            yield panel


_previous_engines = {}  # the engines that each built-in panel had before


def register():
    _register_classes()
    # Each panel gets a new set of engines, since several panels may share one set.
    for panel in list(_compatible_panels()):
        _previous_engines[panel] = panel.__dict__.get("COMPAT_ENGINES")
        panel.COMPAT_ENGINES = panel.COMPAT_ENGINES | {ENGINE}


def unregister():
    for panel, engines in _previous_engines.items():
        if engines is None:
            del panel.COMPAT_ENGINES
        else:
            panel.COMPAT_ENGINES = engines
    _previous_engines.clear()
    _unregister_classes()
