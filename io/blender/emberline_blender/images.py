"""Reads image values as Cycles does. If Blender's glTF exporter would write other values, replaces the image.

The exporter writes values as they are stored. In glTF, colours are sRGB, other values are linear, and alpha is
unassociated.
"""
import os
import re

import bpy
import numpy

_LINEAR = ("Linear", "Linear Rec.709")
_opaque = {}  # for each image's key, whether the image is opaque


def space(image):
    """Returns "sRGB", "linear" or "data", or None for other spaces, which Python cannot convert. Blender converts float
    images to linear when it loads them."""
    settings = image.colorspace_settings
    if settings.is_data or settings.name == "Raw":
        return "data"
    if image.is_float or settings.name in _LINEAR:
        return "linear"
    return "sRGB" if settings.name == "sRGB" else None


def _pixels(image):
    """Returns RGBA as stored, with rows from the bottom. For a tiled image, returns only the first tile."""
    width, height = image.size
    pixels = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)
    if image.channels < 3:
        pixels = numpy.repeat(pixels[:, :, :1], 3, axis=2)
    if pixels.shape[2] == 3:
        pixels = numpy.concatenate([pixels, numpy.ones_like(pixels[:, :, :1])], axis=2)
    return pixels


def is_opaque(image):
    """Whether alpha is 1 everywhere."""
    if not image.is_float and image.depth == 24:
        return True
    path = bpy.path.abspath(image.filepath_raw, library=image.library)
    changed = os.path.getmtime(path) if os.path.isfile(path) else 0
    packed = image.packed_file.size if image.packed_file else 0
    key = (image.name_full, path, changed, packed, image.source, *image.size)
    if image.is_dirty or key not in _opaque:
        _opaque[key] = bool(_pixels(image)[:, :, 3].min() >= 1)
    return _opaque[key]


def _is_associated(image):
    """Whether Cycles multiplies the node's colour by alpha. If the node's alpha is used, Cycles divides by it again."""
    return image.alpha_mode in ("STRAIGHT", "PREMUL") and space(image) != "data"


def linear(image, uses_alpha=False):
    """Returns RGBA as Cycles uses it, with rows from the bottom."""
    pixels = _pixels(image)
    # In Blender's memory, float colours are premultiplied by alpha, and byte colours are not.
    if _is_associated(image) and not uses_alpha and not image.is_float:
        pixels[:, :, :3] *= pixels[:, :, 3:]
    if _is_associated(image) and uses_alpha and image.is_float:
        pixels[:, :, :3] /= numpy.where(pixels[:, :, 3:] == 0, 1, pixels[:, :, 3:])
    if space(image) in ("sRGB", None) and not image.is_float:
        rgb = pixels[:, :, :3]
        pixels[:, :, :3] = numpy.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    if image.alpha_mode == "NONE":
        pixels[:, :, 3] = 1
    return pixels


def is_exported(image, is_colour, uses_alpha):
    """Whether the exported file, read as glTF specifies, has the values that Cycles reads from the image."""
    if image.source == "TILED":
        return False
    kind, settings = space(image), image.colorspace_settings
    if image.is_float:  # the exporter encodes it as sRGB if its colour space is linear
        return (settings.name in _LINEAR if is_colour else settings.is_data) and is_opaque(image)
    if uses_alpha and image.alpha_mode == "NONE" and not is_opaque(image):
        return False
    expected_space = "sRGB" if is_colour else "linear"
    known = kind is None or kind == expected_space or kind == "data" and not is_colour
    return known and (uses_alpha or not _is_associated(image) or is_opaque(image))


def _encoded(image, is_colour, uses_alpha):
    """Creates an image whose stored bytes, read as glTF specifies, are the values that Cycles reads from `image`."""
    pixels = linear(image, uses_alpha).clip(0, 1)
    if is_colour or space(image) is None:
        rgb = pixels[:, :, :3]
        pixels[:, :, :3] = numpy.where(rgb <= 0.0031308, rgb * 12.92, 1.055 * rgb ** (1 / 2.4) - 0.055)
    made = bpy.data.images.new(image.name, *image.size, alpha=True)
    made.pixels.foreach_set(pixels.ravel())
    return made


def uses(node):
    """Returns an image node's links to colours, its links to other values, and whether its alpha is used."""
    colours, values = [], []
    for link in node.outputs["Color"].links:
        (colours if _is_colour(link, set()) else values).append(link)
    return colours, values, node.outputs["Alpha"].is_linked


def _is_colour(link, seen):
    """Whether a link leads to the colour of a shader, directly or through other nodes."""
    node = link.to_node
    if any(output.type == "SHADER" for output in node.outputs):
        return link.to_socket.type == "RGBA"
    if node in seen or node.type in ("GROUP", "NORMAL_MAP"):
        return False
    return any(_is_colour(after, seen | {node}) for output in node.outputs for after in output.links)


def _path(node, frame):
    """Returns the file that a node with an image sequence shows at `frame`. The numbering follows Blender's rules."""
    user, number = node.image_user, node.image_user.frame_current
    if user.use_auto_refresh:
        at, count = frame - user.frame_start + 1, max(user.frame_duration, 1)
        if user.use_cyclic:
            at = (at - 1) % count + 1
        number = min(max(at, 0), count) + user.frame_offset
    stem, suffix = os.path.splitext(bpy.path.abspath(node.image.filepath_raw, library=node.image.library))
    return re.sub(r"\d+(?=\D*$)", lambda digits: str(number).zfill(len(digits[0])), stem) + suffix


def is_missing(node, frame):
    if node.image.source == "SEQUENCE":
        return not os.path.isfile(_path(node, frame))
    return not node.image.size[0]


def differences(image):
    """Returns a line for each way in which Emberline shows the image differently from Blender. The image file must
    exist."""
    warnings = []
    if image.source == "TILED" and len(image.tiles) > 1:
        warnings.append(f"the image '{image.name}' has {len(image.tiles)} tiles (UDIM); only the first one is used")
    if image.source == "MOVIE":
        warnings.append(f"only one frame of the movie '{image.name}' is used")
    if space(image) is None:
        warnings.append(f"the colour space {image.colorspace_settings.name} of the image '{image.name}' is not supported; sRGB is used")
    return warnings


class SubstituteImages:
    """Creates substitute images for one export. Appends them to `ids`, to be removed afterwards."""

    def __init__(self, ids, frame):
        self._ids, self._frame, self._made = ids, frame, {}

    def of(self, node):
        """Returns the substitutes for a node's image, keyed by whether it is used as a colour; {} if none is needed."""
        colours, values, uses_alpha = uses(node)
        if not (colours or values or uses_alpha) or is_missing(node, self._frame):
            return {}
        image = self._loaded(node) if node.image.source == "SEQUENCE" else node.image
        found = {}
        for is_colour in [True] * bool(colours) + [False] * bool(values or not colours):
            # If only alpha is used, the encoding of the colour does not matter.
            encoded = is_colour or not values and space(image) == "sRGB"
            wanted = image
            if image.size[0] and not is_exported(image, encoded, uses_alpha):
                wanted = self._make((image, encoded, uses_alpha), lambda: _encoded(image, encoded, uses_alpha))
            if wanted != node.image:
                found[is_colour] = wanted
        return found

    def _make(self, key, make):
        if key not in self._made:
            self._made[key] = make()
            self._ids.append(self._made[key])
        return self._made[key]

    def _loaded(self, node):
        path, image = _path(node, self._frame), node.image

        def load():
            frame = bpy.data.images.load(path)
            frame.colorspace_settings.name = image.colorspace_settings.name
            frame.alpha_mode = image.alpha_mode
            return frame

        return self._make((path, image), load)


def apply_substitutes(node, substitutes):
    """Applies the result of SubstituteImages.of() to a node; adds a second node if two images are needed."""
    colours, values, _ = uses(node)
    if colours and values and substitutes.get(True) != substitutes.get(False):
        tree = node.id_data
        other = tree.nodes.new(node.bl_idname)
        for name in ("interpolation", "projection", "extension"):
            setattr(other, name, getattr(node, name))
        other.image = substitutes.get(False, node.image)
        for link in node.inputs["Vector"].links:
            tree.links.new(link.from_socket, other.inputs["Vector"])
        for socket in [link.to_socket for link in values]:
            tree.links.new(other.outputs["Color"], socket)
    node.image = substitutes.get(bool(colours), node.image)
