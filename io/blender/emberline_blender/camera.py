"""Converts Blender's camera to the "camera" of Emberline's edits, and its frame to --size and --crop."""
import math

from mathutils import Matrix, Vector

from .command import EmberlineError
from .glb import point


class View:
    """A frame of `width` x `height` pixels, of which only `crop` is visible (x0, y0, x1, y1, counted from the top)."""

    def __init__(self, width, height, crop, edit, placed=None, left=0, bottom=0):
        """`placed` is the camera's matrix with axes of length 1. `left` and `bottom` are the crop's position in a 3D
        viewport's region, in pixels."""
        self.width, self.height, self.crop, self.edit, self.placed = width, height, crop, edit, placed
        self.left, self.bottom = left, bottom

    def animate(self, glb, animation, views):
        """`views` has one view per moment. If they differ, writes a moving camera to the file, and `edit` then refers
        to that camera. Returns the new nodes."""
        angles = [view.edit.get("fov_y") for view in views]
        if all(view.placed == self.placed for view in views) and angles.count(angles[0]) == len(angles):
            return []
        if "fov_y" in self.edit:
            lens = {"type": "perspective", "perspective": {"yfov": math.radians(self.edit["fov_y"]), "znear": 0.01}}
            if angles.count(angles[0]) < len(angles):
                animation.animate_value("/cameras/0/perspective/yfov", [math.radians(angle) for angle in angles])
        else:
            half = self.edit["orthographic_height"] / 2
            lens = {"type": "orthographic", "orthographic": {"ymag": half, "xmag": half * self.width / self.height, "znear": 0, "zfar": 1e6}}
        glb.add("cameras", lens)
        self.edit = {name: self.edit[name] for name in ("f_stop", "focus_distance") if name in self.edit}
        self.edit["file_camera"] = {"index": 0}
        # In glTF and in Blender, cameras look along their node's -Z. axes() would turn that axis; the rotation undoes
        # the turn.
        places = [view.placed @ Matrix.Rotation(-math.pi / 2, 4, "X") for view in views]
        return [animation.node(places, camera=0)]


def pixels(render):
    """Returns the whole frame's size and the render border (x0, y0, x1, y1 from the top), rounded as in Blender."""
    width = render.resolution_x * render.resolution_percentage // 100
    height = render.resolution_y * render.resolution_percentage // 100
    if width < 1 or height < 1:
        raise EmberlineError("Emberline: the frame has no pixels; increase the resolution")
    border = (0, 0, width, height)
    if render.use_border:
        x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
        y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
        border = (x0, height - y1, x1, height - y0)
        if x0 >= x1 or y0 >= y1:
            raise EmberlineError("Emberline: the render region has no pixels; make it larger")
    return width, height, border


def _add_lens(edit, slope, placed, depsgraph):
    """Adds the aperture and the focus distance; `slope` is half the view's height at distance 1."""
    camera = placed.data
    dof, focus = camera.dof, camera.dof.focus_object
    if not dof.use_dof or dof.aperture_fstop <= 0:
        return
    # Emberline's f-number assumes film that is 24 mm high, so the same aperture has a different f-number in Blender.
    opening = 1e-3 * camera.lens / dof.aperture_fstop
    edit["f_stop"] = 0.012 / slope / opening
    distance = dof.focus_distance
    if focus:
        at = focus.evaluated_get(depsgraph).matrix_world.translation
        back = placed.matrix_world.to_3x3().col[2].normalized()
        distance = abs(back.dot(placed.matrix_world.translation - at))
    edit["focus_distance"] = max(distance, 1e-6)


def _up(top):
    """Returns the edit's "up", clamped to its valid range of -1 to 1, which rounding may exceed."""
    return [min(max(c, -1.0), 1.0) for c in point(top)]


def view(depsgraph):
    scene = depsgraph.scene_eval
    if not scene.camera:
        raise EmberlineError("Emberline: the scene has no camera; set one in Scene Properties")
    placed = scene.camera.evaluated_get(depsgraph)
    camera = placed.data
    if placed.type != "CAMERA" or camera.type not in ("PERSP", "ORTHO"):
        raise EmberlineError(f"Emberline: camera '{placed.name}' is not supported; its type must be Perspective or Orthographic")
    width, height, border = pixels(scene.render)

    fit = camera.sensor_fit
    if fit == "AUTO":
        sensor, fitted = camera.sensor_width, max(width, height)
    elif fit == "HORIZONTAL":
        sensor, fitted = camera.sensor_width, width
    else:
        sensor, fitted = camera.sensor_height, height
    # A shifted lens shows a part of a larger frame that is centred on the axis.
    right, up = round(2 * camera.shift_x * fitted), round(2 * camera.shift_y * fitted)
    whole = (width + abs(right), height + abs(up))
    if max(whole) > 65536:
        raise EmberlineError(f"Emberline: camera '{placed.name}' is shifted too far; reduce Shift X and Y")
    x0, y0 = max(right, 0), max(-up, 0)
    crop = (border[0] + x0, border[1] + y0, border[2] + x0, border[3] + y0)

    matrix = placed.matrix_world.to_3x3()
    eye = placed.matrix_world.translation
    # The scale of the camera's object is ignored, as in Cycles.
    back, top = matrix.col[2].normalized(), matrix.col[1].normalized()
    if not (back.length > 0 and top.length > 0 and all(map(math.isfinite, eye))):
        raise EmberlineError(f"Emberline: camera '{placed.name}' has a scale of 0; change its scale")
    edit = {"look_from": point(eye), "look_at": point(Vector(eye) - back), "up": _up(top)}
    right = top.cross(back).normalized()
    if matrix.determinant() < 0:
        edit["mirrored"] = True
        right = -right
    camera_matrix = Matrix((right, top, back)).transposed().to_4x4()
    camera_matrix.translation = eye
    if camera.type == "ORTHO":
        edit["orthographic_height"] = camera.ortho_scale * whole[1] / fitted
        return View(*whole, crop, edit, camera_matrix)
    slope = 0.5 * sensor / camera.lens * whole[1] / fitted
    edit["fov_y"] = math.degrees(2 * math.atan(slope))
    _add_lens(edit, slope, placed, depsgraph)
    return View(*whole, crop, edit, camera_matrix)


def _region_border(context, depsgraph, width, height):
    """Returns the left, bottom, right and top edges of the rendered part of the region, in pixels."""
    space, region_data, scene = context.space_data, context.region_data, depsgraph.scene
    if region_data.view_perspective == "CAMERA":
        camera, render = scene.camera, scene.render
        if not (render.use_border and camera and camera.type == "CAMERA"):
            return 0, 0, width, height
        corners = [region_data.perspective_matrix @ (camera.matrix_world @ c).to_4d() for c in camera.data.view_frame(scene=scene)]
        xs, ys = [c.x / c.w for c in corners], [c.y / c.w for c in corners]

        def at(low, high, part, size):
            return round((low + part * (high - low) + 1) / 2 * size)

        x0, x1 = (at(min(xs), max(xs), part, width) for part in (render.border_min_x, render.border_max_x))
        y0, y1 = (at(min(ys), max(ys), part, height) for part in (render.border_min_y, render.border_max_y))
    elif space.use_render_border:
        x0, x1 = (round(part * width) for part in (space.render_border_min_x, space.render_border_max_x))
        y0, y1 = (round(part * height) for part in (space.render_border_min_y, space.render_border_max_y))
    else:
        return 0, 0, width, height
    x0, x1, y0, y1 = max(x0, 0), min(x1, width), max(y0, 0), min(y1, height)
    if x0 >= x1 or y0 >= y1:
        raise EmberlineError("Emberline: the render region is outside the view")
    return x0, y0, x1, y1


def region_view(context, depsgraph):
    """Returns the view of a 3D viewport, derived from the matrices with which Blender draws it."""
    region_data, space = context.region_data, context.space_data
    width, height = context.region.width, context.region.height
    left, bottom, right_edge, top_edge = _region_border(context, depsgraph, width, height)
    projection, world = region_data.window_matrix, region_data.view_matrix.inverted_safe()
    flat = projection[3][3] != 0  # orthographic
    # `axis` is the point at which the view's axis meets the image, from -1 to 1. If it is off centre, the view is a
    # crop of a larger view that is centred on the axis.
    axis = [projection[i][3] if flat else -projection[i][2] for i in (0, 1)]
    more_x, more_y = round(abs(axis[0]) * width), round(abs(axis[1]) * height)
    whole = (width + more_x, height + more_y)
    if max(whole) > 32768:
        raise EmberlineError("Emberline: the view is zoomed in too far; zoom out")
    x0, y0 = more_x if axis[0] < 0 else 0, more_y if axis[1] > 0 else 0
    crop = (x0 + left, y0 + height - top_edge, x0 + right_edge, y0 + height - bottom)

    back, top = world.col[2].to_3d().normalized(), world.col[1].to_3d().normalized()
    eye = world.translation
    through_camera = region_data.view_perspective == "CAMERA"
    if flat and not through_camera:
        eye = eye + back * space.clip_end  # steps back: Blender's orthographic view also shows what is behind the eye
    edit = {"look_from": point(eye), "look_at": point(eye - back), "up": _up(top)}
    slope = whole[1] / height / projection[1][1]
    if flat:
        edit["orthographic_height"] = 2 * slope
        return View(*whole, crop, edit, left=left, bottom=bottom)
    edit["fov_y"] = math.degrees(2 * math.atan(slope))
    placed = depsgraph.scene_eval.camera
    if through_camera and placed and placed.type == "CAMERA":
        _add_lens(edit, slope, placed.evaluated_get(depsgraph), depsgraph)
    return View(*whole, crop, edit, left=left, bottom=bottom)
