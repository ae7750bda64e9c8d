"""Blender's camera as a view of Emberline's edits, and the picture it shows as --size and --crop."""
import math

from mathutils import Vector

from .command import Refused
from .glb import point


class View:
    """`width`, `height`: of the frame that is rendered, of which `crop` (x0, y0, x1, y1, from the top) is shown."""

    def __init__(self, width, height, crop, edit):
        self.width, self.height, self.crop, self.edit = width, height, crop, edit


def pixels(render):
    """Size of the whole frame, and x0, y0, x1, y1 of the border in it, from the top; as Blender rounds them."""
    width = render.resolution_x * render.resolution_percentage // 100
    height = render.resolution_y * render.resolution_percentage // 100
    if width < 1 or height < 1:
        raise Refused("Emberline: the frame has no pixels; see Resolution")
    border = (0, 0, width, height)
    if render.use_border:
        x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
        y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
        border = (x0, height - y1, x1, height - y0)
        if x0 >= x1 or y0 >= y1:
            raise Refused("Emberline: the render region has no pixels")
    return width, height, border


def _focus_distance(camera, placed, depsgraph):
    focus = camera.dof.focus_object
    if not focus:
        return camera.dof.focus_distance
    at = focus.evaluated_get(depsgraph).matrix_world.translation
    back = placed.matrix_world.to_3x3().col[2].normalized()
    return abs(back.dot(placed.matrix_world.translation - at))


def view(depsgraph):
    scene = depsgraph.scene_eval
    if not scene.camera:
        raise Refused("Emberline: the scene has no camera")
    placed = scene.camera.evaluated_get(depsgraph)
    camera = placed.data
    if placed.type != "CAMERA" or camera.type not in ("PERSP", "ORTHO"):
        raise Refused(f"Emberline: camera '{placed.name}' is neither perspective nor orthographic")
    width, height, border = pixels(scene.render)

    fit = camera.sensor_fit
    if fit == "AUTO":
        sensor, fitted = camera.sensor_width, max(width, height)
    elif fit == "HORIZONTAL":
        sensor, fitted = camera.sensor_width, width
    else:
        sensor, fitted = camera.sensor_height, height
    # A shifted lens shows a part of a larger frame whose middle is the axis.
    right, up = round(2 * camera.shift_x * fitted), round(2 * camera.shift_y * fitted)
    whole = (width + abs(right), height + abs(up))
    if max(whole) > 65536:
        raise Refused(f"Emberline: camera '{placed.name}' is shifted too far")
    x0, y0 = max(right, 0), max(-up, 0)
    crop = (border[0] + x0, border[1] + y0, border[2] + x0, border[3] + y0)

    matrix = placed.matrix_world.to_3x3()
    eye = placed.matrix_world.translation
    # Without the scale of the camera's object, as Cycles has it.
    back, top = matrix.col[2].normalized(), matrix.col[1].normalized()
    if not (back.length > 0 and top.length > 0 and all(map(math.isfinite, eye))):
        raise Refused(f"Emberline: camera '{placed.name}' looks nowhere (its scale is 0)")
    edit = {"look_from": point(eye), "look_at": point(Vector(eye) - back), "up": point(top)}
    if matrix.determinant() < 0:
        edit["mirrored"] = True
    edit["up"] = [min(max(c, -1.0), 1.0) for c in edit["up"]]
    if camera.type == "ORTHO":
        edit["orthographic_height"] = camera.ortho_scale * whole[1] / fitted
        return View(*whole, crop, edit)
    slope = 0.5 * sensor / camera.lens * whole[1] / fitted
    edit["fov_y"] = math.degrees(2 * math.atan(slope))
    dof = camera.dof
    if dof.use_dof and dof.aperture_fstop > 0:
        # Ours counts for film 24 mm high: the same opening has another number.
        opening = 1e-3 * camera.lens / dof.aperture_fstop
        edit["f_stop"] = 0.012 / slope / opening
        edit["focus_distance"] = max(_focus_distance(camera, placed, depsgraph), 1e-6)
    return View(*whole, crop, edit)
