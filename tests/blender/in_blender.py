"""The part of the add-on's tests that runs in Blender. addon_test.py starts it.

    blender -b --factory-startup -P tests/blender/in_blender.py -- CASE FOLDER EMBERLINE

Prints "passed CASE" if the case passes. Otherwise prints "FAILED: ..." and exits with 1.
"""
import os
import struct
import sys
import time
import traceback
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(os.path.dirname(os.path.dirname(HERE)), "io", "blender")]

import bpy  # noqa: E402
import numpy  # noqa: E402

import blender_scenes as scenes  # noqa: E402
import emberline_blender  # noqa: E402
from emberline_blender import command, engine, exr, guard, limits, settings, versions  # noqa: E402

CASE, FOLDER, EMBERLINE = sys.argv[sys.argv.index("--") + 1 :]
TOLERANCE = 0.03


class Failed(Exception):
    pass


def check(holds, said):
    if not holds:
        raise Failed(said)


def use(program):
    settings.preferred_command = lambda: program


def file(name):
    return os.path.join(FOLDER, name)


def render(name="frame.exr"):
    return scenes.render("EMBERLINE", file(name))


def own_types(base):
    """Yields the add-on's subclasses of a Blender type."""
    for kind in base.__subclasses__():
        if kind.__module__.startswith("emberline_blender"):
            yield kind
        yield from own_types(kind)


def is_title(text):
    small = {"a", "and", "for", "from", "in", "of", "on", "or", "the", "to", "with"}
    words = text.split()
    return bool(words) and all(not word[0].islower() or (i and word in small) for i, word in enumerate(words))


def is_tooltip(text):
    return bool(text) and not text[0].islower() and not text.endswith(".")


def labels_and_tooltips():
    """Checks that every property, choice and operator has a tooltip, and that labels are in title case, as in
    Blender."""
    seen = 0
    inherited = {"rna_type", "name", "bl_idname"}
    for kind in (*own_types(bpy.types.PropertyGroup), *own_types(bpy.types.AddonPreferences), *own_types(bpy.types.Operator)):
        rna = kind.bl_rna
        if issubclass(kind, bpy.types.Operator):
            check(is_tooltip(kind.bl_description), f"{kind.__name__} has the tooltip '{kind.bl_description}'")
            check(is_title(kind.bl_label), f"{kind.__name__} has the label '{kind.bl_label}'")
            space, name = kind.bl_idname.split(".")
            rna = getattr(getattr(bpy.ops, space), name).get_rna_type()
        for prop in rna.properties:
            if prop.identifier in inherited or prop.identifier.startswith("bl_"):
                continue
            seen += 1
            what = f"{kind.__name__}.{prop.identifier}"
            check(is_title(prop.name), f"{what} has the label '{prop.name}'")
            check(is_tooltip(prop.description), f"{what} has the tooltip '{prop.description}'")
            for item in getattr(prop, "enum_items", ()):
                check(is_title(item.name) and is_tooltip(item.description), f"{what}: '{item.name}' has '{item.description}'")
    check(seen >= 19, f"only {seen} properties were found")
    panels = list(own_types(bpy.types.Panel))
    check(len(panels) > 5 and all(is_title(panel.bl_label) for panel in panels if hasattr(panel, "bl_label")), "a panel's label")
    for owner in (bpy.types.Scene, bpy.types.ViewLayer):
        check(is_tooltip(owner.bl_rna.properties["emberline"].description), f"{owner.__name__}.emberline has no tooltip")


def compare():
    """Renders each scene (F12) and compares it with Cycles."""
    for name in scenes.SCENES:
        regions = scenes.build(name)
        theirs = scenes.render("CYCLES", file(f"{name} cycles.exr"))
        ours = render(f"{name}.exr")
        height, width = ours.shape[:2]
        check(theirs.shape == ours.shape, f"{name}: another size than Cycles'")
        worst = 0.0
        for region, (x0, y0, x1, y1) in {"whole": (0, 0, width, height), **regions}.items():
            a, b = (p[y0:y1, x0:x1, :3].mean((0, 1)) for p in (theirs, ours))
                # The difference of a nearly black channel is measured relative to the brightest channel.
            difference = numpy.abs(b - a) / numpy.maximum(a, 0.1 * a.max())
            worst = max(worst, difference.max())
            check(difference.max() < TOLERANCE, f"{name}, {region}: {b} where Cycles has {a}")
        print(f"{name}: within {100 * worst:.1f} %")


def light_units():
    """Compares the effect of Blender's options for a light's power with Cycles, by the mean over a floor."""
    has = set(bpy.types.Light.bl_rna.properties.keys())
    kinds = [("AREA", {"shape": "DISK", "size": 0.8}), ("POINT", {"shadow_soft_size": 0.2})]
    if bpy.app.version >= (4, 0):  # in earlier versions, spots are darker towards the edge of the cone
        kinds += [("SPOT", {"spot_size": 0.9, "spot_blend": 0.0, "shadow_soft_size": 0.0})]
    if "normalize" in has:
        kinds += [(kind, {**more, "normalize": False}) for kind, more in kinds] + [("SUN", {"angle": 0.1, "normalize": False})]
    if "use_temperature" in has:
        kinds += [("POINT", {"use_temperature": True, "temperature": 3000, "exposure": 1.5})]
    for kind, more in kinds:
        scenes.build("materials")
        for placed in list(bpy.data.objects):
            bpy.data.objects.remove(placed)
        scenes.floor(scenes.diffuse("floor", (0.7, 0.7, 0.7)), 12)
        scenes.world((0, 0, 0), 0)
        scenes.camera((0, -9, 7), (0, 0, 0))
        scenes.light(kind, 60, (0, 0, 2), **more)
        theirs, ours = (scenes.render(e, file("light.exr"))[20:, :, :3].mean((0, 1)) for e in ("CYCLES", "EMBERLINE"))
        check(numpy.abs(ours / theirs - 1).max() < TOLERANCE, f"{kind} {more}: {ours} where Cycles has {theirs}")


def rejection_message():
    """Renders, and returns the message with which the render fails, as Blender shows it to the user."""
    bpy.context.scene.render.engine = "EMBERLINE"
    try:
        bpy.ops.render.render()
    except RuntimeError as error:
        return str(error).strip()
    raise Failed("rendered what should have been refused")


def expect(words):
    said = rejection_message()
    check(words in said and len(said.splitlines()) == 1, f"expected '{words}', was told: {said}")


def script(name, body):
    path = file(name)
    with open(path, "w", encoding="utf-8") as out:
        out.write("#!/bin/sh\n" + body)
    os.chmod(path, 0o755)
    return path


def refusals():
    scene = bpy.context.scene
    scenes.build("materials")
    scene.camera = None
    expect("no camera")  # this message comes from Blender
    scenes.build("materials")
    scene.render.use_multiview = True
    expect("stereo is not supported")
    scene.render.use_multiview = False
    scene.camera.data.type = "PANO"
    expect("its type must be Perspective or Orthographic")
    scenes.build("materials")
    ball = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name.startswith("plastic"))
    ball.data.vertices[0].co.x = float("nan")
    ball.data.update()
    expect("has vertices with NaN or infinite coordinates")
    scenes.build("materials")
    use(script("crash", "kill -SEGV $$\n"))
    expect("crashed (signal 11)")
    use(script("fail", 'echo "error: no such luck" >&2\nexit 3\n'))
    expect("failed (exit code 3): error: no such luck")
    use(script("lies", "exit 0\n"))
    expect("frame.exr")
    use(file("nothing"))
    expect("is not an executable program")
    # Rendering must still work after these errors.
    use(EMBERLINE)
    check(render().shape[:2] == scenes.SIZE[::-1], "does not render any more")
    check(len(bpy.data.scenes) == 1, "the export's scene has stayed")


def border():
    scenes.build("materials")
    whole = render()
    draw = bpy.context.scene.render
    draw.use_border, draw.use_crop_to_border = True, True
    draw.border_min_x, draw.border_max_x, draw.border_min_y, draw.border_max_y = 0.25, 0.75, 0.125, 0.5
    part = render("part.exr")
    check(part.shape[:2] == (24, 48), f"the cropped border has the size {part.shape}")
    # The pictures are not bit-identical, because Blender's normals of smooth faces differ by rounding between
    # evaluations.
    check(numpy.abs(part - whole[32:56, 24:72]).max() < 1e-5, "the border is not that part of the frame")
    draw.use_crop_to_border = False
    part = render("part.exr")
    check(numpy.abs(part[32:56, 24:72] - whole[32:56, 24:72]).max() < 1e-5, "the border is elsewhere")
    draw.use_border = False


def unusual_paths():
    """Uses blanks and umlauts in the names of the .blend file, the textures, the output and TMPDIR, and unpacks an
    image beside the .blend file."""
    scenes.build("picture_and_lens")
    bpy.ops.wm.save_as_mainfile(filepath=file("Bär & Söhne.blend"))
    inside = render("Größe 1.exr")
    for image in bpy.data.images:
        if image.packed_file:
            image.unpack(method="USE_LOCAL")
    outside = render("Größe 2.exr")
    difference = numpy.abs(inside - outside).max()
    check(difference < 1e-5, f"unpacked images make another picture ({difference})")


def compositor(scene):
    """Returns the compositor's tree, its Render Layers node, and a function that writes a socket to passes/NAME.exr.
    Before Blender 5, the file is passes/NAME0001.exr."""
    old = hasattr(scene, "node_tree")  # Blender 5 has no such attribute
    if old:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
    else:
        scene.compositing_node_group = tree = bpy.data.node_groups.new("compositing", "CompositorNodeTree")
    source, writer = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeOutputFile")
    if old:
        writer.base_path = file("passes")
        writer.file_slots.clear()
        tree.links.new(source.outputs["Image"], tree.nodes.new("CompositorNodeComposite").inputs["Image"])
    else:
        writer.directory, writer.file_name, writer.format.media_type = file("passes"), "", "IMAGE"
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        tree.links.new(source.outputs["Image"], tree.nodes.new("NodeGroupOutput").inputs["Image"])
    writer.format.file_format, writer.format.color_depth = "OPEN_EXR", "32"

    def write(name, socket):
        if old:
            writer.file_slots.new(name)
            tree.links.new(socket, writer.inputs[-1])
        else:
            writer.file_output_items.new({"VALUE": "FLOAT"}.get(socket.type, socket.type), name)
            tree.links.new(socket, writer.inputs[name])

    return tree, source, write


def layers():
    """Checks passes as the compositor reads them, a matte that Blender's Cryptomatte node picks, and that light groups
    add up to the image."""
    scenes.build("materials")
    scene, layer = bpy.context.scene, bpy.context.view_layer
    for name in ("z", "normal", "diffuse_color", "cryptomatte_object"):
        setattr(layer, f"use_pass_{name}", True)
    layer.emberline.use_pass_samples = layer.emberline.use_pass_error = True
    if hasattr(layer, "lightgroups"):
        for group in ("key", "rest"):
            layer.lightgroups.add().name = group
        bpy.data.objects["Area"].lightgroup = "key"
        lamp = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name.startswith("lamp"))
        lamp.lightgroup = scene.world.lightgroup = "rest"
    scene.render.engine = "EMBERLINE"
    scene.render.film_transparent = True
    tree, source, write = compositor(scene)
    matte = tree.nodes.new("CompositorNodeCryptomatteV2")
    names = {"Image": "Image", "Depth": "Depth", "Normal": "Normal", "DiffCol": "DiffCol"}
    names.update({n: n for n in ("Debug Sample Count", "Error", "Combined_key", "Combined_rest") if n in source.outputs})
    for name in [*names, "matte"]:
        write(name, matte.outputs["Matte"] if name == "matte" else source.outputs[names[name]])
    bpy.ops.render.render()
    matte.layer_name = f"{layer.name}.CryptoObject"  # this layer exists only after a render
    sphere = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name.startswith("red"))
    matte.matte_id = sphere.name
    bpy.ops.render.render()
    number = "0001" if bpy.app.version < (5, 0) else ""
    got = {name: scenes.pixels(file(f"passes/{name}{number}.exr")) for name in [*names, "matte"]}
    x, y = 12, 31  # a pixel in the middle of the red ball
    check(6 < got["Depth"][y, x, 0] < 7.5, f"depth {got['Depth'][y, x, 0]}")
    # In Blender, -Y points to the camera and Z points up.
    check(got["Normal"][y, x, 1] < -0.8, f"normal {got['Normal'][y, x]}")
    check(got["Normal"][58, 48, 2] > 0.99, f"normal of the floor {got['Normal'][58, 48]}")
    check(numpy.allclose(got["DiffCol"][y, x, :3], (0.8, 0.1, 0.1), atol=0.02), f"albedo {got['DiffCol'][y, x]}")
    check((got["Debug Sample Count"][..., 0] == 128).all(), "sample counts")
    check(0 < got["Error"][y, x, 0] < 0.1, f"error {got['Error'][y, x]}")
    check(got["Image"][0, 0, 3] == 0 and got["Image"][y, x, 3] > 0.999, "alpha")
    if "Combined_key" in names:
        both = got["Combined_key"][..., :3] + got["Combined_rest"][..., :3]
        check(numpy.allclose(both, got["Image"][..., :3], atol=1e-4), "light groups do not add up")
        check(got["Combined_key"].mean() > 0.05 < got["Combined_rest"].mean(), "an empty light group")
    check(got["matte"][y, x, 0] > 0.999, "the matte misses its object")
    check(10 < got["matte"][..., 0].sum() < 400, "the matte has too much")


def animation():
    """Checks that each frame shows the animated object, material and light as they are in that frame."""
    scenes.build("materials")
    scene = bpy.context.scene
    ball = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name.startswith("plastic"))
    socket = next(n for n in ball.active_material.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"]
    for frame in (1, 2):
        ball.location.z = 0.5 * frame
        ball.keyframe_insert("location", frame=frame)
        socket.default_value = (frame == 2, 0.2, frame == 1, 1)
        socket.keyframe_insert("default_value", frame=frame)
        bpy.data.lights[0].energy = 150.0 * frame
        bpy.data.lights[0].keyframe_insert("energy", frame=frame)
    scene.render.engine, scene.frame_start, scene.frame_end = "EMBERLINE", 1, 2
    scene.frame_set(1)
    scene.render.filepath = file("anim_####")
    bpy.ops.render.render(animation=True)
    frames = [scenes.pixels(file(f"anim_{i:04}.exr")) for i in (1, 2)]
    scene.frame_set(2)
    still = render("still.exr")
    difference = numpy.abs(frames[1] - still).max()
    check(difference < 1e-5, f"the second frame is not the scene at frame 2 ({difference})")
    balls = [f[y : y + 8, 56:64].mean((0, 1)) for f, y in zip(frames, (28, 18))]
    check(balls[0][2] > 2 * balls[0][0] and balls[1][0] > 2 * balls[1][2], f"the material stands still ({balls})")


def environments():
    """Uses an environment file that Blender cannot read, an EXR with its colour in a layer. The emberline command reads
    it directly. An EXR that has only depth must be refused."""
    scenes.build("materials")
    for placed in list(bpy.data.objects):
        if placed.type != "CAMERA":
            bpy.data.objects.remove(placed)
    data, background = scenes.world((0, 0, 0), 1.0)
    picture = data.node_tree.nodes.new("ShaderNodeTexEnvironment")
    data.node_tree.links.new(picture.outputs["Color"], background.inputs["Color"])
    scene = bpy.context.scene

    def use_layers(name, layers):
        """Writes an EXR of 4x2 pixels. `layers` are its channels and their values."""
        exr.write(file(name), numpy.ones((2, 4, 3)))
        with open(file(name), "rb") as before:
            written = before.read()
        listed = b"".join(c + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for c, _ in layers) + b"\0"
        at = written.index(b"channels\0chlist\0") + 16
        (size,) = struct.unpack_from("<i", written, at)
        rest = written[at + 4 + size : len(written) - 2 * (8 + 8 + 48)]  # the header up to the table of rows
        header = written[:at] + struct.pack("<i", len(listed)) + listed + rest
        line = b"".join(numpy.full(4, value, "<f4").tobytes() for _, value in layers)
        first, length = len(header) + 16, len(line)
        lines = [struct.pack("<ii", y, length) + line for y in range(2)]
        with open(file(name), "wb") as out:
            out.write(header + struct.pack("<QQ", first, first + 8 + length) + b"".join(lines))
        picture.image = bpy.data.images.load(file(name))

    use_layers("layered.exr", [(b"Z", 50), (b"sky.B", 0.3), (b"sky.G", 0.2), (b"sky.R", 0.1)])
    check(limits.of_world(data) == [], f"the layered environment is listed: {limits.of_world(data)}")
    got = render()[32, 48, :3]
    check(numpy.abs(got - (0.1, 0.2, 0.3)).max() < 1e-5, f"the layered environment is {got}")
    use_layers("depth.exr", [(b"Z", 50)])
    expect("it has neither channels R, G and B nor a single channel Y; its channels are Z")
    os.remove(file("depth.exr"))
    picture.image = bpy.data.images.load(file("layered.exr"))
    os.rename(file("layered.exr"), file("elsewhere.exr"))
    picture.image.reload()
    check(any("missing" in line for line in limits.of_world(data)), "a missing environment is not listed")
    check(scene.world == data and render()[..., :3].max() == 0, "a missing environment is not black")


def nothing_to_see():
    """Checks that an animation continues through frames that show only the world, because all objects are hidden,
    scaled to zero, or absent."""
    scenes.build("materials")
    scene = bpy.context.scene
    scene.emberline.samples = 16
    placed = [o for o in scene.objects if o.type in ("MESH", "LIGHT")]
    scenes.world((0.2, 0.4, 0.6), 0.5)
    for one in placed:
        for frame, hidden, size in ((1, False, 1), (2, True, 1), (3, False, 0), (4, False, 1)):
            one.hide_render, one.scale = hidden, (size, size, size)
            one.keyframe_insert("hide_render", frame=frame)
            one.keyframe_insert("scale", frame=frame)
    scene.frame_start, scene.frame_end = 1, 4
    for transparent, blurred in ((False, False), (True, False), (False, True)):
        scene.render.film_transparent, scene.render.use_motion_blur, scene.render.motion_blur_shutter = transparent, blurred, 0.01
        scene.render.engine, scene.render.filepath = "EMBERLINE", file(f"anim_{transparent}_{blurred}_####")
        bpy.ops.render.render(animation=True)
        frames = [scenes.pixels(file(f"anim_{transparent}_{blurred}_{i:04}.exr")) for i in range(1, 5)]
        wanted = (0, 0, 0, 0) if transparent else (0.1, 0.2, 0.3, 1)
        check(numpy.abs(frames[1] - wanted).max() < 1e-5, f"a hidden frame is {frames[1][32, 48]}")
        if not blurred:
            check(numpy.abs(frames[2] - wanted).max() < 1e-5, f"a frame scaled to nothing is {frames[2][32, 48]}")
        check(all(numpy.abs(frames[i][30, 12] - wanted).max() > 0.05 for i in (0, 3)), "nothing is shown where something is")
    scene.render.film_transparent = scene.render.use_motion_blur = False
    for one in placed:
        bpy.data.objects.remove(one)
    check(numpy.abs(render()[..., :3] - (0.1, 0.2, 0.3)).max() < 1e-5, "an empty scene is not its world")
    empty = bpy.data.objects.new("empty", bpy.data.meshes.new("no faces"))
    scene.collection.objects.link(empty)
    check(numpy.abs(render()[..., :3] - (0.1, 0.2, 0.3)).max() < 1e-5, "a mesh without faces is not the world alone")
    scenes.light("POINT", 60, (0, 0, 2))
    check(numpy.abs(render()[..., :3] - (0.1, 0.2, 0.3)).max() < 1e-5, "a light alone is not the world alone")


def square():
    """Makes a white square of 1 m on black, in a picture that is 4 m wide, and goes to frame 2."""
    scenes.build("materials")
    for placed in list(bpy.data.objects):
        bpy.data.objects.remove(placed)
    scenes.world((0, 0, 0), 0.0)
    scenes.camera((0, 0, 5), (0, 0, 0), type="ORTHO", ortho_scale=4.0)
    lamp = scenes.principled("lamp", colour=(0, 0, 0), specular=0.0, emission=(1.0, 1.0, 1.0), strength=1.0)
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    own = scene.emberline
    own.pixel_filter, own.filter_width, own.samples = "box", 1.0, 1024
    scene.cycles.pixel_filter_type = "BOX"
    scene.frame_set(2)
    return scenes.add(bpy.ops.mesh.primitive_plane_add, lamp, smooth=False, location=(0, 0, 0), size=1.0)


def blackman_harris(x):
    return 0.35875 + 0.48829 * numpy.cos(numpy.pi * x) + 0.14128 * numpy.cos(2 * numpy.pi * x) + 0.01168 * numpy.cos(3 * numpy.pi * x)


def edge(kind, width):
    """Returns which share of a pixel filter is on one side of an edge, for distances of -3 to 3 pixels between the edge
    and the filter's centre."""
    profiles = {
        "BOX": lambda x: numpy.abs(x) < 0.5,
        "GAUSSIAN": lambda x: numpy.exp(-8 * (x / width) ** 2),
        "BLACKMAN_HARRIS": lambda x: blackman_harris(x / width) * (numpy.abs(x) < width),
    }
    x = (numpy.arange(200000) + 0.5) / 10000 - 10
    cdf = numpy.cumsum(profiles[kind](x).astype(float))
    return numpy.interp(numpy.arange(-3, 4), x + 0.5e-4, cdf / cdf[-1])


def filters():
    """Renders an edge that goes through pixel centres, and a corner, with each of Cycles' filters in two widths.
    Compares the pictures with Cycles and with the closed form."""
    placed = square()
    scene = bpy.context.scene
    scene.render.use_motion_blur = False
    placed.location = (1 / 48, -1 / 48, 0)  # by half a pixel: its upper left corner is at the centre of pixel 36, 20
    scene.cycles.samples = scene.emberline.samples = 1024
    for kind, ours in (("BLACKMAN_HARRIS", "blackman-harris"), ("GAUSSIAN", "gaussian"), ("BOX", "box")):
        for width in (1.5, 2.4):
            scene.cycles.pixel_filter_type, scene.emberline.pixel_filter = kind, ours
            scene.cycles.filter_width = scene.emberline.filter_width = width
            wanted = edge(kind, width)
            for renderer in ("CYCLES", "EMBERLINE"):
                picture = scenes.render(renderer, file(f"{kind} {width} {renderer}.exr"))[..., 0]
                got = picture[26:38, 33:40].mean(0)
                corner = picture[range(20, 23), range(36, 39)]
                # The tolerances allow for Cycles' table of the Blackman-Harris filter, whose tails are slightly larger.
                check(numpy.abs(got - wanted).max() < 0.01, f"{kind} {width}, {renderer}: {got} where {wanted} is right")
                check(numpy.abs(corner - wanted[3:6] ** 2).max() < 0.02, f"{kind} {width}, {renderer}: a corner of {corner}")
                print(f"{kind} {width} {renderer}: corner {corner.round(3)}, edge {got.round(3)}")
    scene.emberline.pixel_filter, scene.emberline.filter_width = "mitchell", 1.5
    check(abs(settings.filter_radius(scene.emberline) - 2) < 1e-6, "a Mitchell of another radius than its usual one")


def moves(owner, path, low, high, index=-1):
    """Animates a property linearly, so that it is `low` at frame 1 and `high` at frame 3. Uses a driver, because
    Blender eases keyframes."""
    driven = owner.driver_add(path, index) if index >= 0 else owner.driver_add(path)
    driven.driver.expression = f"{(low + high) / 2} + {(high - low) / 2} * (frame - 2)"


def trapezoid(middle):
    """Returns for which share of the open shutter the square covers each column, if the square moves by half a
    metre."""
    x = ((numpy.arange(96) + 0.5) / 96 - 0.5) * 4
    return numpy.clip((0.75 - numpy.abs(x - middle)) / 0.5, 0, 1)


def expect_trapezoid(what, middle):
    bpy.context.scene.frame_set(2)
    row = render()[24:40, :, 0].mean(0)
    worst = numpy.abs(row - trapezoid(middle)).max()
    check(worst < 0.02, f"{what}: {worst} from the trapezoid: {row}")


def motion_closed_form():
    """Moves the square, its shape or the camera, at each shutter position, and compares the pictures with the closed
    form. Also checks an object at rest."""
    placed = square()
    scene = bpy.context.scene
    moves(placed, "location", -1, 1, 0)
    for position, middle in (("START", 0.25), ("CENTER", 0.0), ("END", -0.25)):
        versions.shutter_owner(scene).motion_blur_position = position
        expect_trapezoid(position, middle)
    check(abs(scene.frame_current_final - 2) < 1e-6, "the frame has changed")
    versions.shutter_owner(scene).motion_blur_position = "CENTER"
    placed = square()
    parent = bpy.data.objects.new("parent", None)
    scene.collection.objects.link(parent)
    placed.parent, parent.scale = parent, (2, 1, 1)
    placed.rotation_euler, placed.scale = (0, 0, 0.5), (0.7, 0.7, 1)
    moves(parent, "location", -1, 1, 0)
    sheared = render()[..., 0].sum()
    parent.driver_remove("location", 0)
    check(abs(sheared / render("still.exr")[..., 0].sum() - 1) < 0.01, "what is sheared changes its size when it moves")
    placed = square()
    placed.shape_key_add(name="Basis")
    key = placed.shape_key_add(name="aside")
    for point in key.data:
        point.co.x += 1.0
    key.slider_min, key.slider_max = -1.0, 1.0
    moves(key, "value", -1.0, 1.0)
    expect_trapezoid("a shape key", 0.0)
    square()
    moves(scene.camera, "location", 1, -1, 0)
    expect_trapezoid("the camera", 0.0)
    placed = square()
    row = render("rest.exr")[24:40, :, 0].mean(0)
    check(numpy.abs(row - numpy.repeat((0, 1, 0), (36, 24, 36))).max() < 1e-3, f"what stands still is blurred: {row}")


def motion_compare():
    """Compares rotation, deformation and a moving camera with Cycles. The lights stay at rest, because Cycles' lights
    do not move."""
    scenes.build("materials")
    scene = bpy.context.scene
    balls = {o.active_material.name: o for o in scene.objects if o.type == "MESH"}
    bar = scenes.cube(scenes.diffuse("bar", (0.2, 0.7, 0.3)), (-0.6, -0.8, 1.0))
    bar.scale = (1.2, 0.1, 0.1)
    moves(bar, "rotation_euler", -1.5, 1.5, 1)
    bend = balls["plastic"].modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method = "STRETCH"
    moves(bend, "factor", -0.4, 1.2)
    moves(scene.camera, "location", 2.0, 2.4, 2)
    scene.frame_set(2)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.cycles.samples = scene.emberline.samples = 256
    pictures = []
    for steps in (1, 3):
        scene.emberline.motion_steps = steps
        for placed in scene.objects:
            placed.cycles.motion_steps = steps
        theirs = scenes.render("CYCLES", file("motion cycles.exr"))[..., :3]
        ours = render("motion.exr")[..., :3]
        # Compares means of 8x8 pixels. The noise makes them differ by a few hundredths. If an edge moved along a wrong
        # path, they would differ by more than a tenth.
        tiles = [p.reshape(8, 8, 12, 8, 3).mean((1, 3)) for p in (theirs, ours)]
        worst = (numpy.abs(tiles[1] - tiles[0]) / (tiles[0] + 0.05)).max()
        check(worst < 0.08, f"motion with {steps} steps: a tile differs by {worst}")
        difference = abs(ours.mean() / theirs.mean() - 1)
        check(difference < TOLERANCE, f"motion with {steps} steps: the mean differs by {difference}")
        print(f"motion_{steps}: within {100 * worst:.1f} % in tiles, {100 * difference:.1f} % as a whole")
        pictures.append(ours)
    scene.render.use_motion_blur = False
    check(numpy.abs(render("sharp.exr")[..., :3] - pictures[0]).max() > 0.2, "nothing was blurred")


def shows_and_tells():
    """Checks intermediate pictures, heatmaps and the list of differences from Blender, and that no data is left behind
    in bpy.data."""
    scenes.build("materials")
    scene = bpy.context.scene
    own = scene.emberline
    own.driver, own.samples, own.time_limit, own.use_maps = "bisection", 1 << 20, 2.0, True
    own.use_denoising = True
    bpy.data.scenes.new("A scene before")
    counts = [len(d) for d in (bpy.data.scenes, bpy.data.objects, bpy.data.meshes, bpy.data.materials)]
    pictures, take = [], command.Viewer.take
    command.Viewer.take = lambda viewer: pictures.append(take(viewer)) or pictures[-1]
    final = render()
    command.Viewer.take = take
    check(bpy.context.window.scene == scene, "the window shows another scene now")
    left = [len(d) for d in (bpy.data.scenes, bpy.data.objects, bpy.data.meshes, bpy.data.materials)]
    check(left == counts, f"the export has left something in the file: {counts}, then {left}")
    shown = [p for p in pictures if p is not None]
    check(len(shown) >= 2, f"{len(shown)} pictures while it rendered")
    check(abs(shown[-1][..., :3].mean() / final[..., :3].mean() - 1) < 0.05, "another picture than the final one")
    for of in ("samples", "error", "time", "stop"):
        check(bpy.ops.emberline.heatmap(of=of) == {"FINISHED"}, f"no heatmap of {of}")
        image = bpy.data.images[emberline_blender.heatmap.IMAGE]
        check(image.size[0] >= scenes.SIZE[0] and image.packed_file, "the heatmap is no image")
    hair = bpy.data.objects.new("smoke", bpy.data.volumes.new("smoke"))
    scene.collection.objects.link(hair)
    look = bpy.data.materials["red"]
    noise = look.node_tree.nodes.new("ShaderNodeTexNoise")
    diffuse = next(n for n in look.node_tree.nodes if n.type == "BSDF_DIFFUSE")
    look.node_tree.links.new(noise.outputs["Color"], diffuse.inputs["Color"])
    said = dict(limits.of_scene(scene))
    check("volume" in said.get("smoke", ""), f"the volume is not listed: {said}")
    check("Noise" in said.get("red", ""), f"the noise is not listed: {said}")


def long_render():
    """Renders until addon_test.py cancels the render from outside. Blender then continues."""
    scenes.build("materials")
    bpy.context.scene.emberline.samples = 1 << 24
    bpy.context.scene.render.engine = "EMBERLINE"
    watch = engine.EmberlineRenderEngine._wait_for_frame

    def print_child_and_watch(self, process, *more):
        print(f"child {process._child.pid}", flush=True)
        return watch(self, process, *more)

    engine.EmberlineRenderEngine._wait_for_frame = print_child_and_watch
    bpy.ops.render.render()
    check(not os.path.exists(guard.last_frame()), "a cancelled frame has been kept")


def picture_of(image, *sockets, alpha=False, **values):
    """Builds a square that fills the frame, and links an image to sockets of its Principled BSDF. Returns its
    material."""
    scenes.build("materials")
    for placed in list(bpy.data.objects):
        bpy.data.objects.remove(placed)
    scenes.world((0, 0, 0), 0.0)
    scenes.camera((0, 0, 5), (0, 0, 0), type="ORTHO", ortho_scale=1.0)
    scene = bpy.context.scene
    scene.cycles.samples = scene.emberline.samples = 64
    look = scenes.principled("look", **{"colour": (0, 0, 0), "specular": 0.0, "strength": 1.0, **values})
    tree = look.node_tree
    node = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    picture = tree.nodes.new("ShaderNodeTexImage")
    picture.image = image
    for name in sockets:
        tree.links.new(picture.outputs["Color"], next(node.inputs[n] for n in (name, name + " Color") if n in node.inputs))
    if alpha:
        tree.links.new(picture.outputs["Alpha"], node.inputs["Alpha"])
    placed = scenes.add(bpy.ops.mesh.primitive_plane_add, look, smooth=False, location=(0, 0, 0), size=4)
    placed.rotation_euler.x = 0.4  # because Cycles' multiple-scattering metals are black at normal incidence
    return look


def image_of(space, mode="STRAIGHT", opacity=1.0, floats=False, value=0.502):
    image = bpy.data.images.new("picture", 8, 8, alpha=True, float_buffer=floats)
    image.colorspace_settings.name, image.alpha_mode = space, mode
    pixels = numpy.full((8, 8, 4), value, numpy.float32)
    pixels[..., 3] = opacity
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def both(what):
    """Returns the colour of the middle of the frame, and checks that it is alike in both renderers."""
    theirs, ours = (scenes.render(e, file("picture.exr"))[24:40, 40:56, :3].mean((0, 1)) for e in ("CYCLES", "EMBERLINE"))
    check(numpy.abs(ours - theirs).max() < 0.005 + 0.01 * theirs.max(), f"{what}: {ours} where Cycles has {theirs}")
    return ours


def images_as_marked():
    """Compares images with Cycles: images in unsuitable colour spaces, with each alpha mode, as bytes and as floats."""
    straight = next(n for n in ("Linear", "Linear Rec.709") if n in spaces())
    for floats in (False, True):
        for space in ("sRGB", "Non-Color", straight):
            for mode in ("STRAIGHT", "CHANNEL_PACKED", "NONE"):
                image = image_of(space, mode, 0.5, floats)
                picture_of(image, "Emission")
                both(f"a colour of {'floats' if floats else 'bytes'}, {space}, {mode}")
    picture_of(image_of("Non-Color"), "Emission")
    check(abs(both("the issue's")[0] - 0.502) < 0.002, "another value than the stored one")
    for method in ("OPAQUE", "CLIP", "BLEND"):  # only EEVEE uses these methods
        for mode, floats in (("STRAIGHT", False), ("NONE", False), ("STRAIGHT", True)):
            picture_of(image_of("sRGB", mode, 0.5, floats), "Emission", alpha=True).blend_method = method
            scenes.world((0, 0, 1))
            both(f"alpha of {'floats' if floats else 'bytes'}, {mode}, {method}")
        look = picture_of(image_of("sRGB"), "Emission")
        look.blend_method = method
        next(n for n in look.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Alpha"].default_value = 0.3
        both(f"a value of alpha, {method}")
    # If a material uses an image both as colour and as data, the export needs two copies of the image.
    for space, floats in (("sRGB", False), ("Non-Color", False), (straight, False), (straight, True)):
        for sockets in (("Roughness",), ("Base Color", "Roughness")):
            picture_of(image_of(space, floats=floats), *sockets, metallic=1.0, colour=(0.8, 0.8, 0.8))
            scenes.world_picture(20, 1.0)
            both(f"{sockets} of {'floats' if floats else 'bytes'}, {space}")
    check(all(image.packed_file for image in bpy.data.images if image.name.startswith("picture")), "stand-ins have stayed")
    # Images in colour spaces that cannot be converted must be listed.
    other = next(n for n in ("Filmic sRGB", "AgX Base sRGB") if n in spaces())
    look = picture_of(image_of(other), "Emission")
    check(any(other in line for line in limits.of_material(look)), "another colour space is not listed")


def spaces():
    return bpy.types.ColorManagedInputColorspaceSettings.bl_rna.properties["name"].enum_items.keys()


def written(name, colour):
    image = image_of("sRGB")
    image.pixels.foreach_set(numpy.tile(numpy.array((*colour, 1), numpy.float32), 64))
    image.filepath_raw, image.file_format = file(name), "PNG"
    image.save()
    bpy.data.images.remove(image)
    return file(name)


def tiles_and_sequences():
    """Checks that the first tile of a UDIM is rendered, with a warning, that image sequences show the right frame, and
    that the error names a material with which the exporter fails."""
    for number, colour in ((1001, (0.502, 0, 0)), (1002, (0, 0.502, 0))):
        written(f"tiles.{number}.png", colour)
    image = bpy.data.images.load(file("tiles.1001.png"))
    image.source = "TILED"
    image.tiles.new(1002)
    look = picture_of(image, "Emission")
    got = both("a UDIM's first tile")
    check(got[0] > 0.2 > 10 * got[1], f"not the first tile: {got}")
    check(any("2 tiles" in line for line in limits.of_material(look)), "the tiles are not listed")
    for number, colour in ((1, (0.502, 0, 0)), (2, (0, 0.502, 0))):
        last = written(f"frame_{number:03}.png", colour)
    image = bpy.data.images.load(file("frame_001.png"))
    image.source = "SEQUENCE"
    look = picture_of(image, "Emission")
    user = next(n for n in look.node_tree.nodes if n.type == "TEX_IMAGE").image_user
    user.frame_start, user.frame_duration, user.use_auto_refresh = 5, 2, True
    for frame in (5, 6, 9):
        bpy.context.scene.frame_set(frame)
        both(f"frame {frame} of a sequence")
    check(limits.of_material(look) == [], f"a sequence that is there is listed: {limits.of_material(look)}")
    with open(last, "w") as out:
        out.write("no picture")
    check(render().shape[:2] == scenes.SIZE[::-1], "a frame that does not decode ends the render")
    os.remove(last)
    check(any("missing" in line for line in limits.of_material(look)), "a missing frame is not listed")
    bpy.context.scene.frame_set(1)
    look = picture_of(image_of("sRGB"), "Emission")

    def fails(*_):
        raise RuntimeError("Error: no such luck\nError: not today\n")

    kind = bpy.types.EXPORT_SCENE_OT_gltf
    execute = kind.execute
    kind.execute = fails
    expect(f"exporter failed at the material '{look.name}' of 'Plane': RuntimeError: Error: no such luck; Error: not today")
    kind.execute = execute
    check(render().mean() > 0.1, "does not render any more")


def add_to_collection(collection, placed, **flags):
    """Moves objects into a new collection, and sets its flags in the view layer."""
    made = bpy.data.collections.new(collection)
    bpy.context.scene.collection.children.link(made)
    for one in placed:
        for before in list(one.users_collection):
            before.objects.unlink(one)
        made.objects.link(one)
    for name, value in flags.items():
        setattr(bpy.context.view_layer.layer_collection.children[made.name], name, value)


def holdouts():
    """Checks that holdout objects, collections and instancers leave holes, as in Cycles, and that an indirect-only
    object is listed."""
    scene = bpy.context.scene

    def compare_alpha(what, less_than):
        theirs, ours = (scenes.render(e, file(f"{what} {e}.exr")) for e in ("CYCLES", "EMBERLINE"))
        worst = numpy.abs(ours[..., 3] - theirs[..., 3])
        check(abs(ours[..., 3].mean() - theirs[..., 3].mean()) < 0.002 and worst.max() < 0.2, f"{what}: alpha is off by {worst.max()}")
        check(ours[..., 3].mean() < less_than, f"{what}: nothing is held out")
        check(numpy.abs(ours[..., :3].mean() / theirs[..., :3].mean() - 1) < TOLERANCE, f"{what}: another brightness")

    for transparent in (True, False):
        scenes.build("materials")
        scene.render.film_transparent = transparent
        balls = {o.active_material.name.split(".")[0]: o for o in scene.objects if o.type == "MESH"}
        balls["gold"].name = "holdouts"
        whole = render()[..., 3].mean()
        add_to_collection("held", [balls["red"], balls["lamp"]], holdout=True)
        balls["plastic"].is_holdout = True
        compare_alpha(f"a collection, transparent {transparent}", whole - 0.1)
        layer = bpy.context.view_layer
        layer.use_pass_cryptomatte_object = True
        render()
        layer.use_pass_cryptomatte_object = False
    scenes.build("focus")
    scene.camera.data.dof.use_dof = False
    add_to_collection("instancers", [o for o in scene.objects if o.type == "EMPTY"], holdout=True)
    compare_alpha("instancers", 0.999)
    scene.render.use_motion_blur = True
    moves(scene.objects["instance 0"], "location", -1.2, -0.2, 0)
    compare_alpha("moving instancers", 0.999)
    scene.render.use_motion_blur = False
    scenes.build("materials")
    ball = next(o for o in scene.objects if o.type == "MESH" and o.active_material.name.startswith("red"))
    check(not any("camera" in line for name, line in limits.of_scene(scene) if name == ball.name), "listed before it is so")
    add_to_collection("unseen", [ball], indirect_only=True)
    check(any("indirect only" in line for name, line in limits.of_scene(scene) if name == ball.name), "indirect-only is not listed")


def missing_library():
    """Checks that a scene with a missing linked file is rendered without it, and that a warning is shown and is in the
    log (addon_test.py checks the log)."""
    scenes.build("materials")
    cube = bpy.data.objects.new("linked cube", bpy.data.meshes.new("linked mesh"))
    bpy.data.libraries.write(file("library.blend"), {cube})
    with bpy.data.libraries.load(file("library.blend"), link=True) as (_, wanted):
        wanted.objects = ["linked cube"]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    check(not any("missing" in line for _, line in limits.of_scene(bpy.context.scene)), "a library that is there is missed")
    bpy.ops.wm.save_as_mainfile(filepath=file("scene.blend"))
    os.remove(file("library.blend"))
    bpy.ops.wm.open_mainfile(filepath=file("scene.blend"))
    picture = render()
    check(picture[..., :3].mean() > 0.05, "the rest is not rendered")
    check(any("missing" in line for _, line in limits.of_scene(bpy.context.scene)), "the missing file is not listed")


def no_pixels():
    """Checks that Blender reports an error if a resolution percentage leaves no pixel, or if a border lies between two
    pixels."""
    scenes.build("materials")
    draw = bpy.context.scene.render
    draw.resolution_x, draw.resolution_y, draw.resolution_percentage = 4, 4, 1
    expect("too small")
    draw.resolution_percentage = 100
    draw.use_border, draw.use_crop_to_border = True, True
    draw.border_min_x, draw.border_max_x = 0.4, 0.45
    expect("too small")
    draw.use_border = False


def as_installed():
    """Installs the add-on from its zip file as users do. When Blender's operators have enabled it, it must be listed
    and must render."""
    emberline_blender.unregister()
    source = os.path.dirname(os.path.abspath(emberline_blender.__file__))
    archive = file("emberline_blender.zip")
    with zipfile.ZipFile(archive, "w") as out:
        for name in os.listdir(source):
            if name.endswith((".py", ".toml")):
                out.write(os.path.join(source, name), f"emberline_blender/{name}")
    if bpy.app.version >= (4, 2):
        bpy.ops.extensions.package_install_files(repo="user_default", filepath=archive, enable_on_install=True)
        module = "bl_ext.user_default.emberline_blender"
    else:
        bpy.ops.preferences.addon_install(filepath=archive)
        bpy.ops.preferences.addon_enable(module="emberline_blender")
        module = "emberline_blender"
    check(module in bpy.context.preferences.addons, "it is not enabled")
    bpy.context.preferences.addons[module].preferences.command = EMBERLINE
    scenes.build("lights")
    check(render()[..., :3].mean() > 0.05, "no picture")
    bpy.ops.preferences.addon_disable(module=module)
    emberline_blender.register()


def one_of_two():
    scenes.build("lights")
    print(f"mean {render().astype(float).mean():.9f}")


try:
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    emberline_blender.register()
    use(EMBERLINE)
    bpy.ops.outliner.orphans_purge(do_recursive=True)
    start = time.monotonic()
    globals()[CASE]()
    print(f"passed {CASE} in {time.monotonic() - start:.1f} s")
except BaseException as fault:  # without this, Blender would continue and exit with 0
    traceback.print_exc()
    print(f"FAILED: {CASE}: {fault}")
    sys.stdout.flush()
    os._exit(1)
emberline_blender.unregister()
