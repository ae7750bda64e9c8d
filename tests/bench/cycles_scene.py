"""Renders a glTF scene with Cycles inside Blender, for comparison with Emberline.

    blender -b --factory-startup -t 2 --python tests/bench/cycles_scene.py -- settings.json

race_cycles.py writes the settings and runs this script. Cycles uses no denoiser and no clamping, but
caustics, a one-pixel box filter and scene-linear float EXR, so that both renderers estimate the same
picture. Written for Blender 3.4; settings that another version lacks are skipped and listed in the
result.

settings: gltf, env, env_strength, look_from, look_at, fov_y (degrees), width, height, spp (the most,
if adaptive), adaptive, seed, bounces, threads, output (EXR), result (JSON), log (takes Blender's own output).
"""
import json
import math
import os
import re
import sys
import time
import traceback

import bpy
from mathutils import Matrix, Vector

SKIPPED = []


def put(owner, name, value):
    try:
        setattr(owner, name, value)
    except (AttributeError, TypeError):
        SKIPPED.append(name)


def cpu_seconds():
    t = os.times()
    return t.user + t.system


def process_age():
    """Returns the seconds since the process started. The kernel records the start to 10 ms."""
    with open("/proc/self/stat") as f:
        started = int(f.read().rpartition(")")[2].split()[19]) / os.sysconf("SC_CLK_TCK")
    return time.clock_gettime(time.CLOCK_BOOTTIME) - started


def peak_bytes():
    with open("/proc/self/status") as f:
        return int(re.search(r"VmHWM:\s*(\d+) kB", f.read()).group(1)) * 1024


class FirstSample:
    """Notes when Cycles first reports samples. Blender 3.4 passes the handler no text but has just
    printed it, so this reads the log's last line."""

    def __init__(self, log):
        self.log = log
        self.age = self.cpu = None

    def __call__(self, *arguments):
        if self.age is not None:
            return
        text = next((a for a in arguments if isinstance(a, str)), "")
        if not text:
            with open(self.log, "rb") as f:
                f.seek(max(0, os.path.getsize(self.log) - 400))
                text = f.read().decode(errors="replace").rstrip("\n").rpartition("\n")[2]
        if re.search(r"Sample \d+/\d+", text):
            self.age, self.cpu = process_age(), cpu_seconds()


def import_scene(s):
    import numpy

    if "bool" not in numpy.__dict__:  # 3.4's importer uses numpy.bool, which NumPy 1.24 dropped
        numpy.bool = bool
    for o in list(bpy.data.objects):
        bpy.data.objects.remove(o, do_unlink=True)
    op = bpy.ops.import_scene.gltf
    import_options = {
        "filepath": s["gltf"],
        "merge_vertices": False,
        "import_shading": "NORMALS",
        # In this mode 1 candela is radiant intensity 1, and 1 lux is irradiance 1, as in Emberline.
        "convert_lighting_mode": "COMPAT",
        "export_import_convert_lighting_mode": "COMPAT",
    }
    supported_options = set(op.get_rna_type().properties.keys())
    op(**{k: v for k, v in import_options.items() if k in supported_options})
    for light in bpy.data.lights:  # glTF's lights have no size
        if light.type == "SUN":
            light.angle = 0.0
        else:
            light.shadow_soft_size = 0.0


def make_camera(s):
    """Creates the camera. Y points up in glTF, and Z points up in Blender."""
    eye, at = (Vector((v[0], -v[2], v[1])) for v in (s["look_from"], s["look_at"]))
    back = (eye - at).normalized()
    right = Vector((0, 0, 1)).cross(back).normalized()
    rotation = Matrix((right, back.cross(right), back)).transposed().to_4x4()
    camera = bpy.data.cameras.new("race")
    camera.sensor_fit = "VERTICAL"
    camera.angle_y = math.radians(s["fov_y"])
    camera.clip_start, camera.clip_end = 1e-4, 1e9
    placed = bpy.data.objects.new("race", camera)
    placed.matrix_world = Matrix.Translation(eye) @ rotation
    bpy.context.scene.collection.objects.link(placed)
    bpy.context.scene.camera = placed


def make_world(s):
    world = bpy.data.worlds.new("race")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputWorld")
    background = tree.nodes.new("ShaderNodeBackground")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Color"].default_value = (0, 0, 0, 1)
    if not s.get("env"):
        return
    image = bpy.data.images.load(s["env"])
    for name in ("Linear Rec.709", "Linear"):
        try:
            image.colorspace_settings.name = name
            break
        except TypeError:
            pass
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = image
    coordinate = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinate.outputs["Generated"], environment.inputs["Vector"])
    tree.links.new(environment.outputs[0], background.inputs["Color"])
    background.inputs["Strength"].default_value = s.get("env_strength", 1.0)


def set_up_render(s):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = s["width"], s["height"]
    render.resolution_percentage = 100
    render.use_persistent_data = render.use_compositing = render.use_sequencer = False
    put(render, "dither_intensity", 0.0)
    render.threads_mode, render.threads = "FIXED", s["threads"]
    cycles.device = "CPU"
    cycles.samples, cycles.seed = s["spp"], s["seed"]
    cycles.use_adaptive_sampling, cycles.use_denoising = s["adaptive"], False
    cycles.adaptive_threshold, cycles.adaptive_min_samples = 0.01, 0  # Blender's defaults
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.blur_glossy = 0.0
    put(cycles, "use_fast_gi", False)
    put(cycles, "use_light_tree", False)  # not worth it for one or two lights
    for kind in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(cycles, kind + "_bounces", s["bounces"])
    cycles.transparent_max_bounces = 64
    cycles.min_light_bounces = cycles.min_transparent_bounces = 0
    cycles.pixel_filter_type = "BOX"
    cycles.film_exposure = 1.0
    cycles.use_auto_tile = False
    scene.view_settings.view_transform = "Raw"
    settings = render.image_settings
    settings.file_format, settings.color_mode = "OPEN_EXR", "RGB"
    settings.color_depth, settings.exr_codec = "32", "ZIP"


def main(s):
    sys.stdout.flush()
    log = os.open(s["log"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    try:
        import_scene(s)
    except RuntimeError as error:  # raised by a failed operator
        with open(s["result"], "w") as f:
            json.dump({"unreadable": str(error).strip().splitlines()[0]}, f)
        return
    make_camera(s)
    make_world(s)
    set_up_render(s)
    result = {"ready_s": process_age(), "ready_cpu_s": cpu_seconds()}
    first = FirstSample(s["log"])
    bpy.app.handlers.render_stats.append(first)
    bpy.ops.render.render(write_still=False)
    result.update(
        blender=bpy.app.version_string,
        first_sample_s=first.age,
        first_sample_cpu_s=first.cpu,
        done_s=process_age(),
        done_cpu_s=cpu_seconds(),
        peak_rss_bytes=peak_bytes(),
        skipped=SKIPPED,
        unreadable_images=[i.name for i in bpy.data.images if i.source == "FILE" and not i.size[0]],
    )
    bpy.data.images["Render Result"].save_render(s["output"])
    with open(s["result"], "w") as f:
        json.dump(result, f)


try:
    with open(sys.argv[sys.argv.index("--") + 1]) as settings_file:
        main(json.load(settings_file))
except BaseException:  # otherwise Blender continues and exits with 0
    traceback.print_exc()
    sys.stderr.flush()
    os._exit(1)
