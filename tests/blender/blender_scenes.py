"""Builds scenes in Blender. The add-on's tests render them with Emberline and Cycles.

Each scene's function builds it in an empty file and returns named regions of its picture, as x0, y0, x1, y1 in pixels
from the top left. The parts of the picture where the renderers differ are outside the regions, or the scene names them.
"""
import math

import bpy
import numpy
from mathutils import Vector

SIZE = (96, 64)


def principled(name, **values):
    """Makes a material with a Principled BSDF. The names in `values` are translated to the socket names of Blender 3 or
    4."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    node = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    node.distribution = "MULTI_GGX"  # with this, rough metal loses no energy, as in Emberline
    names = {
        "colour": ("Base Color",),
        "metallic": ("Metallic",),
        "roughness": ("Roughness",),
        "transmission": ("Transmission", "Transmission Weight"),
        "ior": ("IOR",),
        "specular": ("Specular", "Specular IOR Level"),
        "emission": ("Emission", "Emission Color"),
        "strength": ("Emission Strength",),
    }
    for key, value in values.items():
        socket = next(node.inputs[n] for n in names[key] if n in node.inputs)
        socket.default_value = (*value, 1.0) if isinstance(value, tuple) else value
    return material


def diffuse(name, colour):
    """Makes a diffuse material that both renderers shade alike. In Blender 3, the diffuse lobe of the Principled BSDF
    is Disney's and not Lambert's, so this uses a Diffuse BSDF."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, node = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*colour, 1.0)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def add(mesh_operator, material, smooth=True, **where):
    mesh_operator(**where)
    placed = bpy.context.object
    placed.data.materials.append(material)
    if smooth:
        for face in placed.data.polygons:
            face.use_smooth = True
    return placed


def sphere(material, location, radius=0.5):
    return add(bpy.ops.mesh.primitive_uv_sphere_add, material, location=location, radius=radius, segments=64, ring_count=32)


def cube(material, location, size=1.0):
    return add(bpy.ops.mesh.primitive_cube_add, material, smooth=False, location=location, size=size)


def floor(material, size=8.0, z=0.0):
    return add(bpy.ops.mesh.primitive_plane_add, material, smooth=False, location=(0, 0, z), size=size)


def camera(eye, at, lens=50.0, **more):
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    for name, value in more.items():
        setattr(data, name, value)
    placed = bpy.data.objects.new("Camera", data)
    placed.location = eye
    placed.rotation_euler = (Vector(at) - Vector(eye)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(placed)
    bpy.context.scene.camera = placed
    return placed


def light(kind, energy, location, at=(0, 0, 0), **more):
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy = energy
    for name, value in more.items():
        setattr(data, name, value)
    placed = bpy.data.objects.new(kind.title(), data)
    placed.location = location
    placed.rotation_euler = (Vector(at) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(placed)
    return placed


def world(colour, strength=1.0):
    data = bpy.data.worlds.new("World")
    data.use_nodes = True
    node = next(n for n in data.node_tree.nodes if n.type == "BACKGROUND")
    node.inputs["Color"].default_value = (*colour, 1.0)
    node.inputs["Strength"].default_value = strength
    bpy.context.scene.world = data
    return data, node


def world_picture(turn_degrees, strength):
    """Makes a sky from a float image that is packed into the file. Its four sides differ, so that a wrong rotation or
    mirroring is visible."""
    data, background = world((0, 0, 0), strength)
    width, height = 64, 32
    u, v = numpy.meshgrid((numpy.arange(width) + 0.5) / width, (numpy.arange(height) + 0.5) / height)
    pixels = numpy.ones((height, width, 4), numpy.float32)
    pixels[..., 0] = 0.2 + 0.8 * (u < 0.25)
    pixels[..., 1] = 0.2 + 0.8 * ((u > 0.25) & (u < 0.5))
    pixels[..., 2] = 0.2 + 0.8 * v + 2.0 * ((u > 0.6) & (u < 0.7) & (v > 0.6) & (v < 0.75))
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    tree = data.node_tree
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = image
    mapping, coordinate = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
    mapping.inputs["Rotation"].default_value[2] = math.radians(turn_degrees)
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], picture.inputs["Vector"])
    tree.links.new(picture.outputs["Color"], background.inputs["Color"])


def textured(name):
    material = principled(name, roughness=0.5, specular=0.0)
    tree = material.node_tree
    picture = tree.nodes.new("ShaderNodeTexImage")
    image = bpy.data.images.new("chequers", 8, 8)
    pixels = numpy.ones((8, 8, 4), numpy.float32)
    pixels[::2, ::2, :3] = pixels[1::2, 1::2, :3] = (0.8, 0.3, 0.1)
    pixels[:4, :4, 2] = 0.9
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    picture.image, picture.interpolation = image, "Closest"
    node = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    tree.links.new(picture.outputs["Color"], node.inputs["Base Color"])
    return material


def materials():
    """Spheres with different base colours, metals, roughness and emission, under an area light and a grey world."""
    floor(diffuse("floor", (0.5, 0.5, 0.5)))
    looks = (
        diffuse("red", (0.8, 0.1, 0.1)),
        principled("gold", colour=(0.9, 0.6, 0.2), metallic=1.0, roughness=0.35),
        principled("plastic", colour=(0.1, 0.3, 0.8), roughness=0.3),
        principled("lamp", colour=(0, 0, 0), emission=(1.0, 0.7, 0.3), strength=2.0),
    )
    for i, look in enumerate(looks):
        sphere(look, (1.2 * (i - 1.5), 0, 0.5))
    light("AREA", 150, (1.5, -2, 3), shape="RECTANGLE", size=1.5, size_y=0.7)
    world((0.3, 0.35, 0.4), 0.5)
    camera((0, -6.5, 2.2), (0, 0, 0.5))
    return {"red": (6, 26, 18, 38), "gold": (30, 26, 42, 38), "floor": (8, 46, 88, 62)}


def glass():
    """A glass sphere and a mirror sphere in a rotated sky, to compare what they refract and reflect."""
    sphere(principled("glass", colour=(1, 1, 1), transmission=1.0, roughness=0.0, ior=1.45), (-0.7, 0, 0), 0.6)
    sphere(principled("mirror", colour=(0.9, 0.9, 0.9), metallic=1.0, roughness=0.05), (0.7, 0, 0), 0.6)
    world_picture(70, 1.5)
    camera((0, -4, 0.6), (0, 0, 0))
    return {"sky": (0, 0, 96, 10), "glass": (24, 24, 36, 40), "mirror": (60, 24, 72, 40)}


def lights():
    """A sun with an angle, and a point light with a radius, a spot and a disc, each above another part of the floor."""
    floor(diffuse("floor", (0.7, 0.7, 0.7)), 12)
    box = diffuse("box", (0.4, 0.6, 0.4))
    for x in (-3, -1, 1, 3):
        cube(box, (x, 0.4, 0.25), 0.5)
    light("POINT", 60, (-3, -0.6, 1.6), shadow_soft_size=0.2, color=(1, 0.5, 0.5))
    light("SPOT", 300, (-1, -0.6, 3), at=(-1, 0, 0), spot_size=0.9, spot_blend=0.4, shadow_soft_size=0.0, color=(0.5, 1, 0.5))
    light("AREA", 60, (1, -0.6, 1.6), at=(1, 0, 0), shape="DISK", size=0.8, color=(0.5, 0.5, 1))
    light("SUN", 0.8, (5, -3, 5), angle=math.radians(5))
    camera((0, -9, 7), (0, 0, 0))
    return {"point": (16, 30, 32, 48), "spot": (32, 30, 48, 48), "disc": (48, 30, 64, 48), "sun": (70, 30, 90, 60)}


def picture_and_lens():
    """An image texture, a rotated sky, a shifted lens with a vertical sensor, and a resolution percentage."""
    placed = floor(textured("chequers"), 4)
    placed.scale = (1, 0.7, 1)
    sphere(principled("metal", colour=(0.8, 0.8, 0.8), metallic=1.0, roughness=0.5), (0, 0, 0.5))
    world_picture(-130, 1.0)
    camera((0.5, -4, 2.5), (0, 0, 0.2), lens=35, sensor_fit="VERTICAL", sensor_height=24, shift_x=0.15, shift_y=-0.1)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 192, 128, 50
    return {"sky": (0, 0, 96, 6), "floor": (20, 30, 60, 50)}


def focus():
    """Depth of field, a modifier with more levels in renders than in the viewport, and instances of a collection."""
    floor(diffuse("floor", (0.3, 0.3, 0.35)), 30)
    colours = ((0.9, 0.2, 0.1), (0.2, 0.8, 0.2), (0.2, 0.3, 0.9))
    parts = bpy.data.collections.new("parts")
    ball = sphere(diffuse("white", (0.8, 0.8, 0.8)), (0, 0, 0.25), 0.25)
    for collection in ball.users_collection:
        collection.objects.unlink(ball)
    parts.objects.link(ball)
    for i, colour in enumerate(colours):
        placed = cube(diffuse(f"colour {i}", colour), (1.3 * (i - 1), 2.5 * i - 1, 0.6), 1.2)
        round_off = placed.modifiers.new("round", "SUBSURF")
        round_off.levels, round_off.render_levels = 0, 3
        instance = bpy.data.objects.new(f"instance {i}", None)
        instance.instance_type, instance.instance_collection = "COLLECTION", parts
        instance.location = (1.3 * (i - 1) + 0.6, 2.5 * i - 2, 0)
        bpy.context.scene.collection.objects.link(instance)
    light("SUN", 3.0, (3, -3, 6), angle=0.0)
    world((0.5, 0.6, 0.8), 0.4)
    placed = camera((0, -7, 2), (0, 1, 0.5), lens=60)
    placed.data.dof.use_dof = True
    placed.data.dof.focus_distance, placed.data.dof.aperture_fstop = 6.0, 0.2
    return {"near": (18, 28, 30, 42), "middle": (42, 20, 54, 32), "far": (60, 16, 70, 26), "floor": (0, 50, 96, 64)}


SCENES = {f.__name__: f for f in (materials, glass, lights, picture_and_lens, focus)}


def build(name):
    """Builds the scene `name` in an empty file, sets it up for both renderers, and returns its regions."""
    for scene_object in list(bpy.data.objects):
        bpy.data.objects.remove(scene_object)
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x, render.resolution_y = SIZE
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", 2
    render.dither_intensity = 0.0
    render.image_settings.file_format, render.image_settings.color_mode = "OPEN_EXR", "RGBA"
    render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    cycles = scene.cycles
    cycles.device, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", False, False
    cycles.samples, cycles.seed = 128, 1
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, kind + "_bounces", 12)
    scene.emberline.driver, scene.emberline.samples, scene.emberline.seed = "bucket", 128, 1
    return SCENES[name]()


def pixels(path):
    """Returns R, G, B and A of an EXR that Blender wrote, in rows from the top."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, -1)[::-1]


def render(engine, path):
    scene = bpy.context.scene
    scene.render.engine, scene.render.filepath = engine, path
    bpy.ops.render.render(write_still=True)
    return pixels(path)
