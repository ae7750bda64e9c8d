"""Defines render settings with Cycles' names and units, and converts them to command-line options."""
import zlib

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

# The --filter-radius for a filter width of 1 in Cycles. Blackman-Harris ends at a radius that equals the width. The
# Gaussian's sigma is a quarter of the width in Cycles and a third of the radius in Emberline. Cycles has no Mitchell
# filter; the factor here gives it the usual radius of 2 at the default width.
_RADII = {"blackman-harris": 1.0, "gaussian": 0.75, "mitchell": 4 / 3}


class EmberlineSettings(bpy.types.PropertyGroup):
    driver: EnumProperty(
        name="Driver",
        description="Order in which pixels are sampled",
        items=(
            ("adaptive", "Adaptive", "Render the whole frame at once and take more samples in noisy areas"),
            ("bisection", "Bisection", "Render the whole frame at once and refine it evenly"),
            ("bucket", "Bucket", "Finish one bucket at a time; needs the least memory"),
        ),
        default="adaptive",
    )
    samples: IntProperty(
        name="Samples",
        description="Number of samples per pixel; an average with the adaptive driver",
        default=128,
        min=1,
        soft_max=4096,
        max=16777216,
    )
    viewport_samples: IntProperty(
        name="Viewport Samples",
        description="Average number of samples per pixel that the viewport takes when nothing changes",
        default=1024,
        min=1,
        soft_max=4096,
        max=16777216,
    )
    use_noise_threshold: BoolProperty(
        name="Use Noise Threshold",
        description="Stop sampling a pixel when its noise is below the threshold; not available with the Bisection driver",
        default=False,
    )
    noise_threshold: FloatProperty(
        name="Noise Threshold",
        description="RMS error in the displayed picture at which a pixel is finished: 0.02 leaves visible noise, 0.005 hardly any",
        default=0.01,
        min=0.000001,
        max=1.0,
        precision=4,
    )
    time_limit: FloatProperty(
        name="Time Limit",
        description="Stop rendering after this time and keep the picture so far; 0 means no limit",
        default=0.0,
        min=0.0,
        max=1e9,
        subtype="TIME",
        unit="TIME_ABSOLUTE",
    )
    max_bounces: IntProperty(name="Max Bounces", description="Largest number of bounces; 0 means direct light only", default=12, min=0, max=1024)
    clamp_indirect: FloatProperty(
        name="Clamp Indirect",
        description="Upper limit for the indirect light of a sample, to reduce fireflies; 0 means no clamping",
        default=0.0,
        min=0.0,
        max=1e9,
    )
    seed: IntProperty(name="Seed", description="Change the seed to get different noise", default=0, min=0)
    use_animated_seed: BoolProperty(name="Animate Seed", description="Use different noise in each frame", default=True)
    pixel_filter: EnumProperty(
        name="Pixel Filter",
        description="Filter that weights the samples around each pixel",
        items=(
            ("blackman-harris", "Blackman-Harris", "Similar to the Gaussian and slightly sharper at the same width"),
            ("gaussian", "Gaussian", "Soft picture"),
            ("box", "Box", "Average over the pixel; most aliasing"),
            ("mitchell", "Mitchell", "Sharp picture with slight ringing and more noise"),
        ),
        default="blackman-harris",
    )
    filter_width: FloatProperty(
        name="Filter Width",
        description="Width of the filter in pixels, as in Cycles; a box is always one pixel wide",
        default=1.5,
        min=0.02,
        max=10.0,
        subtype="PIXEL",
    )
    motion_steps: IntProperty(
        name="Motion Steps",
        description="Sample the motion at 2^steps + 1 moments while the shutter is open",
        default=1,
        min=1,
        max=7,
    )
    use_denoising: BoolProperty(
        name="Denoise",
        description="Denoise the Combined pass; the 'Noisy Image' pass keeps the picture before denoising",
        default=False,
    )
    use_maps: BoolProperty(
        name="Record Maps",
        description="Record the error, the time and the stop reason of each pixel for the heatmaps below",
        default=False,
    )


def _passes_changed(_settings, context):
    if context.view_layer:
        context.view_layer.update_render_passes()


class EmberlineLayerSettings(bpy.types.PropertyGroup):
    use_pass_samples: BoolProperty(
        name="Sample Count",
        description="Add a pass with the number of samples of each pixel",
        default=False,
        update=_passes_changed,
    )
    use_pass_error: BoolProperty(
        name="Error",
        description="Add a pass with the standard error of each pixel's radiance",
        default=False,
        update=_passes_changed,
    )


class EmberlinePreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    command: StringProperty(
        name="Program",
        description="Path of the emberline program; leave empty to search PATH and the add-on's folders",
        default="",
        subtype="FILE_PATH",
    )

    def draw(self, context):
        from . import command

        self.layout.prop(self, "command")
        try:
            self.layout.label(text=command.find(self.command), icon="CHECKMARK")
        except command.EmberlineError as fault:
            self.layout.label(text=str(fault), icon="ERROR")


def preferred_command():
    addon = bpy.context.preferences.addons.get(__package__)
    return bpy.path.abspath(addon.preferences.command) if addon and addon.preferences else ""


def filter_radius(own):
    """Returns the filter radius in pixels. As in Cycles, the width has no effect on a box filter."""
    return own.filter_width * _RADII[own.pixel_filter] if own.pixel_filter in _RADII else 0.5


def _sample_options(scene, samples, seed):
    own, render = scene.emberline, scene.render
    arguments = ["--spp", str(samples), "--max-depth", str(own.max_bounces + 1), "--seed", str(seed % 2**32)]
    arguments += ["--filter", own.pixel_filter, "--filter-radius", repr(max(filter_radius(own), 0.01))]
    if own.clamp_indirect > 0:
        arguments += ["--clamp-indirect", repr(own.clamp_indirect)]
    if own.use_denoising:
        arguments += ["--denoise"]
    if render.film_transparent:
        arguments += ["--transparent"]
    if render.threads_mode == "FIXED":
        arguments += ["--threads", str(render.threads)]
    return arguments


def options(scene):
    own = scene.emberline
    # A sum would give the next frame the noise that this frame has with the next seed.
    seed = zlib.crc32(f"{own.seed} {scene.frame_current}".encode()) if own.use_animated_seed else own.seed
    arguments = ["--driver", own.driver] + _sample_options(scene, own.samples, seed)
    if own.use_noise_threshold and own.driver != "bisection":
        arguments += ["--noise-threshold", repr(own.noise_threshold)]
    if own.time_limit > 0:
        arguments += ["--time-limit", repr(max(own.time_limit, 0.001))]
    return arguments


def viewport_options(scene):
    """Returns the options of a viewport, which has its own driver and no time limit."""
    return _sample_options(scene, scene.emberline.viewport_samples, scene.emberline.seed)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory((EmberlineSettings, EmberlineLayerSettings, EmberlinePreferences))


def register():
    _register_classes()
    bpy.types.Scene.emberline = PointerProperty(type=EmberlineSettings, name="Emberline", description="Render settings of Emberline")
    bpy.types.ViewLayer.emberline = PointerProperty(type=EmberlineLayerSettings, name="Emberline", description="Passes of Emberline")


def unregister():
    del bpy.types.ViewLayer.emberline
    del bpy.types.Scene.emberline
    _unregister_classes()
