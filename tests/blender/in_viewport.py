"""The half of the viewport's tests that runs in a Blender with a window: addon_test.py starts it, under Xvfb.

    blender --factory-startup -P tests/blender/in_viewport.py -- CASE FOLDER EMBERLINE

A case is a generator that a timer goes through: each `yield` lets Blender draw. Screenshots are looked at as pixels.
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
from emberline_blender import settings, viewport  # noqa: E402

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


def until(good, said, seconds=20):
    """Waits for it; afterwards `took` has the seconds."""
    global took
    began = time.perf_counter()
    while not good():
        if time.perf_counter() - began > seconds:
            port = the_viewport()
            raise Failed(f"{said} (the viewport says: {port and port._said})")
        yield
    took = time.perf_counter() - began


def new_picture(after=None, samples=0.0):
    def good():
        port = the_viewport()
        now = port and port._picture
        if not now or now is after:
            return False
        message = now.message
        return message["complete"] and message["samples"] >= samples * message["width"] * message["height"]

    return good


def shown(seconds=0.3):
    """Lets the picture there is come to the screen."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        yield


def screenshot(name="screen.png"):
    """The viewport's region as it is on the screen, 0 to 1, rows from the top."""
    path = os.path.join(FOLDER, name)
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.screen.screenshot(filepath=path)
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = numpy.empty(width * height * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    pixels = pixels.reshape(height, width, 4)
    r = region()
    return pixels[r.y : r.y + r.height, r.x : r.x + r.width, :3][::-1]


def mean(picture, x0, y0, x1, y1):
    """Of a part, in parts of the whole."""
    h, w = picture.shape[:2]
    return picture[int(y0 * h) : int(y1 * h), int(x0 * w) : int(x1 * w)].mean((0, 1))


def look(**more):
    space = area().spaces.active
    space.overlay.show_overlays = space.show_gizmo = False
    for name, value in more.items():
        setattr(space.region_3d, name, value)
    space.shading.type = "RENDERED"


def begin(name="materials"):
    scenes.build(name)
    bpy.context.scene.emberline.viewport_samples = 64
    bpy.context.scene.render.engine = "EMBERLINE"
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 960, 640
    look(view_perspective="CAMERA")
    yield from until(new_picture(samples=16), "no picture", 30)


def material_of(name):
    return bpy.data.materials[name]


def shows():
    """The picture, through the camera, with Blender's colours; then a move of the view, of an object, a light, a material."""
    yield from begin()
    print(f"first picture after {took:.2f} s")
    yield from shown()
    first = screenshot("first.png")
    h, w = first.shape[:2]
    print("middle", mean(first, 0.3, 0.3, 0.7, 0.7))


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
        try:
            screenshot("failed.png")
        except Exception:
            pass
        print(f"FAILED: {CASE}: {fault}", flush=True)
        finish(1)


bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
emberline_blender.register()
settings.preferred_command = lambda: EMBERLINE
bpy.context.preferences.view.show_splash = False
generator = globals()[CASE]()
bpy.app.timers.register(lambda: run(generator), first_interval=0.5)
