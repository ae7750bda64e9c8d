"""Exports the world as Emberline's environment: a colour, or an environment texture with a rotation."""
import math
import os

import bpy
import numpy

from . import exr, images, lights

_LINEAR = ("Linear", "Linear Rec.709", "Non-Color", "Raw")


def background_node(world):
    """Returns the Background node that is connected to the world's active output, or None."""
    source = lights.active_surface_node(world.node_tree, "OUTPUT_WORLD")
    return source if source and source.type == "BACKGROUND" else None


def environment_node(world):
    background = background_node(world)
    if not background or not background.inputs["Color"].is_linked:
        return None
    source = background.inputs["Color"].links[0].from_node
    return source if source.type == "TEX_ENVIRONMENT" and source.image else None


def rotation(environment):
    """Returns the rotation in degrees, as for --env-rotation."""
    if not environment.inputs["Vector"].is_linked:
        return 0.0
    mapping = environment.inputs["Vector"].links[0].from_node
    if mapping.type != "MAPPING":
        return 0.0
    # A Mapping node rotates the lookup direction. A Mapping node of type Texture applies the inverse rotation.
    angle = math.degrees(mapping.inputs["Rotation"].default_value[2])
    return angle if mapping.vector_type == "TEXTURE" else -angle


def directly_readable_path(image):
    """Returns the image's path if the command itself can read the file (including EXR layers), or else None."""
    path = bpy.path.abspath(image.filepath_raw, library=image.library)
    linear = image.colorspace_settings.name in _LINEAR
    kept = image.source == "FILE" and not image.packed_file and not image.is_dirty
    return path if kept and linear and path.lower().endswith((".hdr", ".exr")) and os.path.isfile(path) else None


def options(world, folder):
    """Returns the command's --env options. Without a world, the environment is black, as in Cycles."""
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
    source = node and directly_readable_path(node.image)
    if source or node and node.image.size[0] and node.image.size[1]:
        if not source:
            exr.write(path, numpy.maximum(images.linear(node.image)[::-1, :, :3], 0))
        path = source or path
        return ["--env", path, "--env-strength", repr(strength), "--env-rotation", repr(rotation(node))]
    exr.write(path, numpy.full((2, 4, 3), [max(c, 0.0) for c in rgb], numpy.float32))
    return ["--env", path, "--env-strength", repr(strength)]
