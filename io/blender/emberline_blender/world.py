"""The world as Emberline's environment: a colour, or an environment texture that may be turned."""
import math
import os

import bpy
import numpy

from . import exr, lights

_LINEAR = ("Linear", "Linear Rec.709", "Non-Color", "Raw")


def background_node(world):
    """The Background node of the world's active output, if that is what it is."""
    return lights.shown_node(world.node_tree, "OUTPUT_WORLD", "BACKGROUND")


def environment_node(world):
    background = background_node(world)
    if not background or not background.inputs["Color"].is_linked:
        return None
    source = background.inputs["Color"].links[0].from_node
    return source if source.type == "TEX_ENVIRONMENT" and source.image else None


def turn(environment):
    """Degrees, as --env-rotation has them."""
    if not environment.inputs["Vector"].is_linked:
        return 0.0
    mapping = environment.inputs["Vector"].links[0].from_node
    if mapping.type != "MAPPING":
        return 0.0
    # A Mapping node turns the direction that is looked up; a texture mapping does the opposite.
    angle = math.degrees(mapping.inputs["Rotation"].default_value[2])
    return angle if mapping.vector_type == "TEXTURE" else -angle


def _picture(image):
    """Linear R G B, rows from the top."""
    width, height = image.size
    pixels = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)[::-1]
    if image.channels < 3:
        pixels = numpy.repeat(pixels[:, :, :1], 3, axis=2)
    pixels = pixels[:, :, :3]
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        pixels = numpy.where(pixels <= 0.04045, pixels / 12.92, ((pixels + 0.055) / 1.055) ** 2.4)
    return pixels


def options(world, folder):
    """--env and what belongs to it; without a world the environment is black, as in Cycles."""
    strength, rgb, node = 1.0, (0.0, 0.0, 0.0), None
    if world:
        rgb = world.color
        if getattr(world, "use_nodes", True) and world.node_tree:
            background = background_node(world)
            node = environment_node(world)
            rgb = (0.0, 0.0, 0.0)
            if background:
                strength = max(background.inputs["Strength"].default_value, 0.0)
                rgb = background.inputs["Color"].default_value[:3]
    path = os.path.join(folder, "world.exr")
    if node and node.image.size[0] and node.image.size[1]:
        source = bpy.path.abspath(node.image.filepath_raw, library=node.image.library)
        linear = node.image.colorspace_settings.name in _LINEAR
        as_is = source.lower().endswith((".hdr", ".exr")) and linear and not node.image.packed_file
        if as_is and not node.image.is_dirty and node.image.source == "FILE" and os.path.isfile(source):
            path = source
        else:
            exr.write(path, numpy.maximum(_picture(node.image), 0))
        return ["--env", path, "--env-strength", repr(strength), "--env-rotation", repr(turn(node))]
    exr.write(path, numpy.full((2, 4, 3), [max(c, 0.0) for c in rgb], numpy.float32))
    return ["--env", path, "--env-strength", repr(strength)]
