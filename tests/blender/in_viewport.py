"""The part of the viewport's tests that runs in a Blender with a window. addon_test.py starts it under Xvfb.

    blender --factory-startup -P tests/blender/in_viewport.py -- CASE FOLDER EMBERLINE

A case is a generator that a timer runs. Each `yield` lets Blender draw. Screenshots are compared by their pixels.
"""
import os
import signal
import sys
import time
import traceback

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(os.path.dirname(HERE)), "io", "blender")]

import bpy  # noqa: E402
import numpy  # noqa: E402

import blender_scenes as scenes  # noqa: E402
import emberline_blender  # noqa: E402
from emberline_blender import session, settings, viewport  # noqa: E402

CASE, FOLDER, EMBERLINE = sys.argv[sys.argv.index("--") + 1 :]


class Failed(Exception):
    pass


def check(holds, said):
    if not holds:
        raise Failed(said)


def area():
    return next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == "VIEW_3D")


def region():
    return next(r for r in area().regions if r.type == "WINDOW")


def the_viewport():
    return next(iter(viewport._viewports), None)


def until(is_ready, said, seconds=60):
    """Waits until `is_ready()` returns true, and stores how many seconds this took in `took`."""
    global took
    began = time.perf_counter()
    while not is_ready():
        if time.perf_counter() - began > seconds:
            port = the_viewport()
            raise Failed(f"{said} (the viewport says: {port and port._status})")
        yield
    took = time.perf_counter() - began


def new_picture(after=None, samples=0.0):
    def is_ready():
        port = the_viewport()
        now = port and port._picture
        if not now or now is after:
            return False
        message = now.message
        return message["complete"] and message["samples"] >= samples * message["width"] * message["height"]

    return is_ready


def wait_for_screen(seconds=0.3):
    """Gives the current picture time to appear on the screen."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        yield


def screenshot():
    """Returns the viewport's region of the screen, with values from 0 to 1, in rows from the top. It reads the memory
    of Xvfb, which is a file in XWD format."""
    path = os.path.join(os.environ["EMBERLINE_TEST_SCREEN"], "Xvfb_screen0")
    data = numpy.fromfile(path, numpy.uint8)
    head = data[:100].view(">u4")
    height, line, begin = head[5], head[12], head[0] + 12 * head[19]
    pixels = data[begin : begin + height * line].reshape(height, line // 4, 4)[..., 2::-1] / 255
    r = region()
    window = bpy.context.window_manager.windows[0]
    top = window.height - r.y - r.height
    return pixels[top : top + r.height, r.x : r.x + r.width]


def set_view(**more):
    space = area().spaces.active
    space.overlay.show_overlays = space.show_gizmo = False
    for name, value in more.items():
        setattr(space.region_3d, name, value)
    space.shading.type = "RENDERED"


def begin(name="materials", samples=8):
    scenes.build(name)
    scene = bpy.context.scene
    scene.emberline.viewport_samples = 64
    scene.render.engine = "EMBERLINE"
    # The view renders only a small region, which saves time.
    space = area().spaces.active
    space.use_render_border = scene.render.use_border = True
    yield
    set_view(view_perspective="CAMERA")
    yield from until(new_picture(samples=samples), "no picture")


said = []  # the commands sent to sessions, as (command, members)


def record_commands():
    send_command = session.Session.send_command

    def record_command(self, do, **members):
        if do != "next":
            said.append((do, members))
        send_command(self, do, **members)

    session.Session.send_command = record_command


def take_commands():
    """Returns the commands sent since the last call."""
    names = [do for do, _ in said]
    said.clear()
    return names


def frame():
    """Returns the camera's frame in the region as left, top, right and bottom, in pixels from the top left."""
    camera, matrix = bpy.context.scene.camera, area().spaces.active.region_3d.perspective_matrix
    corners = [matrix @ (camera.matrix_world @ c).to_4d() for c in camera.data.view_frame(scene=bpy.context.scene)]
    xs = [(c.x / c.w + 1) / 2 * region().width for c in corners]
    ys = [(1 - c.y / c.w) / 2 * region().height for c in corners]
    return min(xs), min(ys), max(xs), max(ys)


def in_frame(picture, x0, y0, x1, y1):
    """Returns the mean colour of a part of the camera's frame. The part is given in pixels of the F12 render."""
    left, top, right, bottom = frame()
    sx, sy = (right - left) / scenes.SIZE[0], (bottom - top) / scenes.SIZE[1]
    rows = slice(int(top + y0 * sy), int(top + y1 * sy))
    return picture[rows, int(left + x0 * sx) : int(left + x1 * sx)].mean((0, 1))


def viewport_shows():
    """Checks that the viewport's picture matches the F12 render within the camera's frame, with Blender's display
    transform."""
    yield from begin(samples=32)
    yield from wait_for_screen()
    first = screenshot()
    bpy.context.scene.view_settings.view_transform = "Standard"
    yield from wait_for_screen()
    standard = screenshot()
    bpy.context.scene.view_settings.view_transform = "Raw"
    bpy.context.scene.render.use_border = False
    still = scenes.render("EMBERLINE", os.path.join(FOLDER, "still.exr"))[..., :3]
    for name, (x0, y0, x1, y1) in {"red": (6, 26, 18, 38), "floor": (8, 46, 88, 62), "sky": (4, 2, 90, 14)}.items():
        wanted, got = still[y0:y1, x0:x1].clip(0, 1).mean((0, 1)), in_frame(first, x0, y0, x1, y1)
        check(numpy.abs(got - wanted).max() < 0.012, f"{name}: {got} where F12 has {wanted}")
        encoded = in_frame(standard, x0, y0, x1, y1)
        sky = 1.055 * wanted ** (1 / 2.4) - 0.055
        check(name != "sky" or numpy.abs(encoded - sky).max() < 0.012, f"{name}: {encoded}, not as displayed: {sky}")
        print(f"{name}: {got} {wanted}")


def viewport_changes():
    """Checks that each change sends the expected commands and is visible, and that nothing is sent without changes."""
    record_commands()
    yield from begin()
    check(take_commands().count("open") == 1, "one scene was to be opened")
    yield from wait_for_screen(1.0)
    check(take_commands() == [], "something is sent while nothing changes")
    exports = []
    export = viewport.Export._export_parts
    viewport.Export._export_parts = lambda *a: exports.append(1) or export(*a)

    def change(what, made, seen, only, exported=0):
        before = the_viewport()._picture
        edits_before = before.message["edit"]
        made()

        def there():
            now = the_viewport()._picture
            return now is not before and now.message["edit"] > edits_before and seen(now.pixels)

        yield from until(there, f"{what} is not seen")
        print(f"{what}: seen after {took:.2f} s")
        yield from wait_for_screen(0.5)
        names = take_commands()
        check(set(names) <= only, f"{what}: {names} was sent")
        check(names.count("open") <= 1, f"{what}: opened {names.count('open')} times")
        check(len(exports) == exported, f"{what}: {len(exports)} exports of meshes")
        exports.clear()

    def colours(pixels):
        return pixels.reshape(-1, 4)[:, :3].astype(float)

    scene, space = bpy.context.scene, area().spaces.active
    level = colours(the_viewport()._picture.pixels).mean()

    def brighter():
        bpy.data.objects["Area"].data.energy = 600

    yield from change("a light", brighter, lambda p: colours(p).mean() > 1.5 * level, {"edits"})

    def away():
        for placed in scene.objects:
            if placed.type == "MESH" and placed.active_material.name == "red":
                placed.location.z = 50

    def reds(pixels):
        c = colours(pixels)
        return int(((c[:, 0] > 4 * c[:, 1]) & (c[:, 0] > 0.05)).sum())

    check(reds(the_viewport()._picture.pixels) > 100, "no red ball")
    yield from change("an object", away, lambda p: reds(p) < 50, {"settings", "open", "camera"})

    def green():
        nodes = bpy.data.materials["floor"].node_tree.nodes
        next(n for n in nodes if n.type == "BSDF_DIFFUSE").inputs["Color"].default_value = (0.1, 0.8, 0.1, 1)

    def greener(pixels):
        c = colours(pixels).mean(0)
        return c[1] > 1.5 * c[0]

    yield from change("a material", green, greener, {"edits"})

    def daylight():
        next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND").inputs["Strength"].default_value = 20

    bright = colours(the_viewport()._picture.pixels).mean()
    yield from change("the world", daylight, lambda p: colours(p).mean() > 1.5 * bright, {"settings", "edits"})
    check(greener(the_viewport()._picture.pixels), "the material is as it was before its edit")

    def textured():
        node = next(n for n in bpy.data.materials["floor"].node_tree.nodes if n.type == "BSDF_DIFFUSE")
        source = node.id_data.nodes.new("ShaderNodeTexImage")
        source.image = bpy.data.images.new("red", 4, 4)
        source.image.pixels.foreach_set(numpy.tile(numpy.array((0.8, 0.1, 0.1, 1), numpy.float32), 16))
        source.image.colorspace_settings.name = "Non-Color"  # for such an image, the export makes a second image
        node.id_data.links.new(source.outputs[0], node.inputs["Color"])

    yield from change("nodes", textured, lambda p: not greener(p), {"settings", "open", "camera"}, 1)

    def alone():
        placed = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name == "plastic")
        for other in scene.objects:
            other.select_set(other == placed)
        bpy.context.view_layer.objects.active = placed
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area(), region=region()):
            bpy.ops.view3d.localview(frame_selected=False)

    def whole():
        with bpy.context.temp_override(window=bpy.context.window_manager.windows[0], area=area(), region=region()):
            bpy.ops.view3d.localview(frame_selected=False)

    yield from change("local view", alone, lambda p: not (colours(p)[:, 0] > 1.5 * colours(p)[:, 1]).any(), {"settings", "open", "camera"})
    yield from change("all of it", whole, lambda p: (colours(p)[:, 0] > 1.5 * colours(p)[:, 1]).any(), {"settings", "open", "camera"})

    def removed():
        bpy.data.objects.remove(next(o for o in scene.objects if o.type == "MESH" and o.active_material.name == "floor"))

    yield from change("a deletion", removed, lambda p: True, {"settings", "open", "camera"}, 1)

    def other_material():
        placed = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name == "plastic")
        placed.active_material = bpy.data.materials["red"]
        nodes = bpy.data.materials["red"].node_tree.nodes  # at the same time, edits a material
        next(n for n in nodes if n.type == "BSDF_DIFFUSE").inputs["Color"].default_value = (0.8, 0.05, 0.05, 1)

    yield from change("another material", other_material, lambda p: reds(p) > 100, {"settings", "open", "camera"}, 1)

    def from_above():
        scene.render.use_border = False
        space.region_3d.view_perspective = "ORTHO"
        space.region_3d.view_rotation = (1, 0, 0, 0)

    yield from change("a view", from_above, lambda p: True, {"settings", "camera"})
    check("orthographic_height" in the_viewport()._view.edit, "not an orthographic view")
    scenes.render("EMBERLINE", os.path.join(FOLDER, "still.exr"))
    # For F12, Blender ends the engines of the viewports, and then it restarts them.
    yield from until(new_picture(), "no viewport after F12")
    yield from wait_for_screen(0.5)
    check(len(viewport._viewports) == 1 and take_commands().count("open") == 1,
          "after F12, there is not exactly one viewport that was opened exactly once")


def viewport_borders():
    """Checks that a border in a user's view renders only that part of the view, in the right place. Also checks a
    camera view that is panned off the centre."""
    scenes.build("materials")
    bpy.context.scene.render.engine = "EMBERLINE"
    bpy.context.scene.emberline.viewport_samples = 16
    space = area().spaces.active
    set_view(view_perspective="PERSP", view_rotation=bpy.context.scene.camera.rotation_euler.to_quaternion(), view_distance=9.0, view_location=(0, 0, 0.5))
    yield from until(new_picture(samples=8), "no picture")
    yield from wait_for_screen()
    whole = screenshot()
    space.render_border_min_x, space.render_border_max_x = 0.3, 0.6
    space.render_border_min_y, space.render_border_max_y = 0.35, 0.65
    space.use_render_border = True
    wanted = (round(0.6 * region().width) - round(0.3 * region().width), round(0.65 * region().height) - round(0.35 * region().height))

    def size():
        message = the_viewport()._picture.message
        return (message["width"], message["height"])

    yield from until(lambda: size() == wanted and new_picture(samples=8)(), "not the border")
    yield from wait_for_screen()
    part = screenshot()
    h, w = whole.shape[:2]
    for x0, x1, y0, y1 in ((0.32, 0.44, 0.37, 0.48), (0.46, 0.58, 0.5, 0.63)):
        at = slice(int(y0 * h), int(y1 * h)), slice(int(x0 * w), int(x1 * w))
        a, b = whole[at].mean((0, 1)), part[at].mean((0, 1))
        check(numpy.abs(a - b).max() < 0.02, f"the border shows {b} where the whole has {a}")
    space.use_render_border = False
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_offset = (0.2, -0.1)
    whole_size = (region().width, region().height)
    yield from until(lambda: size() == whole_size and new_picture(samples=8)(), "no picture of the camera's view")
    yield from wait_for_screen(1.0)
    screen = screenshot()
    still = scenes.render("EMBERLINE", os.path.join(FOLDER, "still.exr"))[..., :3]
    got, wanted = in_frame(screen, 6, 26, 18, 38), still[26:38, 6:18].clip(0, 1).mean((0, 1))
    check(numpy.abs(got - wanted).max() < 0.02, f"off the middle: {got} where F12 has {wanted}")


def viewport_animation():
    """Renders an animation from the window, in Blender's render thread, while a viewport also renders."""
    yield from begin()
    scene = bpy.context.scene
    ball = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name.startswith("plastic"))
    ball.driver_add("location", 2).driver.expression = "0.5 * frame"
    scene.render.use_motion_blur = True
    scene.render.use_border = False
    scene.frame_start, scene.frame_end, scene.render.filepath = 1, 3, os.path.join(FOLDER, "anim_####")
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.render.render("INVOKE_DEFAULT", animation=True)
    last = os.path.join(FOLDER, "anim_0003.exr")
    yield from until(lambda: os.path.exists(last) and not bpy.app.is_job_running("RENDER"), "the animation does not end", 120)
    balls = [scenes.pixels(os.path.join(FOLDER, f"anim_000{i}.exr"))[:, 50:66, 2].mean() for i in (1, 3)]
    check(abs(balls[0] - balls[1]) > 0.02, f"the frames are alike: {balls}")
    check(len(bpy.data.scenes) == 1, "the export's scene has stayed")
    yield from wait_for_screen(0.5)
    yield from until(new_picture(samples=1), "no viewport after it")


def viewport_large():
    """Measures how long the first picture of a scene with 100,000 triangles takes, and a picture after the view
    moves."""
    record_commands()
    scenes.build("materials")
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=224, y_subdivisions=224, size=3, location=(0, 0, 1.5))
    scene, space = bpy.context.scene, area().spaces.active
    count = sum(len(o.data.polygons) * 2 for o in scene.objects if o.type == "MESH")
    check(count >= 100000, f"{count} triangles")
    scene.render.engine = "EMBERLINE"
    yield from wait_for_screen()
    set_view(view_perspective="CAMERA")
    yield from until(lambda: the_viewport() and the_viewport()._picture, "no picture")
    print(f"large: {count} triangles, {region().width}x{region().height}, first picture after {took:.2f} s")
    check(took < 10, "the first picture took too long")
    yield from wait_for_screen(1.0)
    space.region_3d.view_perspective = "PERSP"
    yield from wait_for_screen(0.5)
    times = []
    for i in range(10):
        before = the_viewport()._picture.message["edit"]
        said.clear()
        space.region_3d.view_distance *= 1.02
        yield from until(lambda: the_viewport()._picture.message["edit"] > before, "the view does not move")
        times.append(took)
        check(take_commands() == ["camera"], "more than the camera was sent")
    print(f"large: a move of the view is there after {1000 * sorted(times)[5]:.0f} ms (median of 10)")
    check(sorted(times)[5] < 2, "a move of the view takes too long")


def viewport_ends():
    """Checks that the viewport reports a killed renderer, that other shading stops the renderer, and that two viewports
    have separate renderers."""
    yield from begin()
    child = the_viewport()._session._child.pid
    os.kill(child, signal.SIGKILL)
    yield from until(lambda: "signal 9" in (the_viewport()._status or ""), "its end is not said")
    yield from wait_for_screen(0.5)
    area().spaces.active.shading.type = "SOLID"
    yield from until(lambda: not the_viewport(), "the viewport's session is still there")
    area().spaces.active.shading.type = "RENDERED"
    yield from until(new_picture(), "it does not begin anew")
    window = bpy.context.window_manager.windows[0]
    both = [area()]
    other = next(a for a in window.screen.areas if a.type == "DOPESHEET_EDITOR")
    other.type = "VIEW_3D"
    other.spaces.active.shading.type = "RENDERED"
    both.append(other)
    yield from until(lambda: len(viewport._viewports) == 2, "no second viewport")
    yield from until(lambda: all(v._picture for v in viewport._viewports), "one of two has no picture")
    changed = viewport.camera.region_view
    viewport.camera.region_view = lambda *_: 1 / 0
    other.tag_redraw()
    yield from until(lambda: any("ZeroDivisionError" in (v._status or "") for v in viewport._viewports), "a fault of ours is not said")
    viewport.camera.region_view = changed
    for viewed in both:
        viewed.spaces.active.shading.type = "SOLID"
    yield from until(lambda: not the_viewport(), "a viewport that has failed stays")
    for viewed in both:
        viewed.spaces.active.shading.type = "RENDERED"
    yield from until(lambda: len(viewport._viewports) == 2 and all(v._picture for v in viewport._viewports), "they do not begin anew")
    children = {v._session._child.pid for v in viewport._viewports}
    check(len(children) == 2, "two viewports share a session")
    for viewed in both:
        viewed.spaces.active.shading.type = "SOLID"
    yield from until(lambda: not any(os.path.exists(f"/proc/{c}") for c in children), "a session outlives its viewport")


def finish(code):
    sys.stdout.flush()
    emberline_blender.unregister()
    os._exit(code)


def run(case):
    try:
        next(case)
        return 0.01
    except StopIteration:
        print(f"passed {CASE}", flush=True)
        finish(0)
    except BaseException as fault:
        traceback.print_exc()
        print(f"FAILED: {CASE}: {fault}", flush=True)
        finish(1)


bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
emberline_blender.register()
settings.preferred_command = lambda: EMBERLINE
bpy.context.preferences.view.show_splash = False
generator = globals()[CASE]()
bpy.app.timers.register(lambda: run(generator), first_interval=0.5)
