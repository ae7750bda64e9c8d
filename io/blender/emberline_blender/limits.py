"""Lists, per object, what Emberline shows differently from Blender, for the panel."""
import json
import os

import bpy

from . import images, lights, materials, versions, world

# Nodes that Blender's glTF exporter or this add-on reads. Other nodes are reported as ignored.
_SUPPORTED_NODES = {
    "OUTPUT_MATERIAL", "BSDF_PRINCIPLED", "EMISSION", "BSDF_DIFFUSE", "BSDF_GLOSSY", "TEX_IMAGE", "MAPPING", "UVMAP",
    "NORMAL_MAP", "SEPRGB", "SEPARATE_COLOR", "FRAME", "REROUTE", "RGB", "VALUE", "TEX_COORD",
}  # fmt: skip
_SUPPORTED_SURFACES = {"BSDF_PRINCIPLED", "EMISSION", "BSDF_DIFFUSE", "BSDF_GLOSSY"}
_SUPPORTED_TYPES = {"MESH", "CURVE", "SURFACE", "FONT", "META", "LIGHT", "CAMERA", "EMPTY", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}
_KINDS = {"VOLUME": "volume", "CURVES": "hair curves", "POINTCLOUD": "point cloud", "GPENCIL": "grease pencil", "GREASEPENCIL": "grease pencil"}
_MAX_OBJECTS = 2000  # largest scene that is examined while a panel is drawn

_from_renders = {}  # lines from the last frame's report, by scene
_cache = {}  # lines, by scene
_dirty = True


def of_material(material):
    if not material.use_nodes or not material.node_tree:
        return []
    surface = materials.surface_node(material)
    warnings = []
    if surface and surface.type not in _SUPPORTED_SURFACES:
        warnings.append(f"the surface node '{surface.name}' ({surface.bl_label}) is not supported; use a Principled BSDF")
    for node in materials.used_nodes(material.node_tree):
        if node.type == "OUTPUT_MATERIAL":
            for what in ("Volume", "Displacement"):
                if node.inputs[what].is_linked:
                    warnings.append(f"the {what.lower()} is ignored")
        elif node.type not in _SUPPORTED_NODES and node is not surface:
            warnings.append(f"the node '{node.name}' ({node.bl_label}) is ignored")
        elif node.type == "TEX_IMAGE" and node.image:
            image = node.image
            warnings += [f"the image '{image.name}' is missing"] if images.is_missing(node, bpy.context.scene.frame_current) else images.differences(image)
            if image.is_float:
                warnings.append(f"the image '{image.name}' is reduced to 8 bits; values above 1 are clipped")
        elif node.type == "BSDF_PRINCIPLED":
            for what in ("Subsurface", "Subsurface Weight", "Anisotropic", "Diffuse Roughness"):
                entry = node.inputs.get(what)
                if entry and (entry.is_linked or entry.default_value > 0):
                    warnings.append(f"{what} is ignored")
    return warnings


def of_light(data):
    warnings = []
    if data.use_nodes and data.node_tree:
        emission = lights.emission_node(data)
        if not emission or any(emission.inputs[i].is_linked for i in ("Color", "Strength")):
            warnings.append("the nodes are ignored, except for the colour and strength of an Emission node")
    if data.type == "SPOT" and data.shadow_soft_size > 0:
        warnings.append("the radius of a spot light is ignored; its shadows are sharp")
    if not versions.casts_shadows(data):
        warnings.append("the light casts shadows, although they are turned off")
    if data.type == "AREA" and data.spread < 3.1:
        warnings.append("the spread is ignored; the light shines over a hemisphere")
    if data.type == "SPOT" and data.spot_size > 3.14:
        warnings.append("the cone is limited to 180 degrees")
    return warnings


def of_world(data):
    if not data or not getattr(data, "use_nodes", True) or not data.node_tree:
        return []
    background, warnings = world.background_node(data), []
    if not background:
        return ["the surface is not a Background node; the world is black"]
    if background.inputs["Strength"].is_linked:
        warnings.append("the nodes that set the strength are ignored")
    environment = world.environment_node(data)
    if background.inputs["Color"].is_linked and not environment:
        warnings.append("the nodes that set the colour are ignored, except for an Environment Texture")
    if environment:
        if not environment.image.size[0] and not world.directly_readable_path(environment.image):
            warnings.append(f"the image '{environment.image.name}' is missing; the world is black")
        if environment.image.source not in ("FILE", "GENERATED"):
            warnings.append("only one frame of the environment image is used")
        elif environment.image.size[0]:
            warnings += images.differences(environment.image)
        if environment.projection != "EQUIRECTANGULAR":
            warnings.append("the projection of the environment is ignored; it is rendered as equirectangular")
        if environment.inputs["Vector"].is_linked:
            node = environment.inputs["Vector"].links[0].from_node
            turned = node.inputs["Rotation"].default_value if node.type == "MAPPING" else (0, 0, 0)
            if node.type not in ("MAPPING", "TEX_COORD") or abs(turned[0]) + abs(turned[1]) > 1e-6:
                warnings.append("only the rotation of the environment about Z is used")
    return warnings


def of_object(scene, obj):
    warnings = []
    if obj.type in _KINDS:
        warnings.append(f"objects of type {_KINDS[obj.type]} are not rendered")
    elif obj.type not in _SUPPORTED_TYPES:
        warnings.append(f"objects of type {obj.type} are not rendered")
    if any(system.settings.type == "HAIR" and system.settings.render_type == "PATH" for system in obj.particle_systems):
        warnings.append("hair is not rendered")
    layer = bpy.context.view_layer
    if obj.type != "LIGHT" and layer and obj.visible_camera and obj.indirect_only_get(view_layer=layer):
        warnings.append("it is visible to camera rays, although its collection is indirect only")
    for kind in ("camera", "diffuse", "glossy", "transmission", "shadow"):
        if obj.type != "LIGHT" and not getattr(obj, f"visible_{kind}", True):
            warnings.append(f"it is visible to {kind} rays, although this is turned off")
    if obj.type != "LIGHT" and getattr(obj, "is_shadow_catcher", False):
        warnings.append("Shadow Catcher is ignored")
    linking = getattr(obj, "light_linking", None)
    if linking and (linking.receiver_collection or linking.blocker_collection):
        warnings.append("light linking is ignored; its light reaches all objects, and all objects block it")
    if obj.type == "LIGHT":
        warnings += of_light(obj.data)
        if not obj.visible_camera and lights.in_view(scene, scene.camera, obj.data, obj.matrix_world):
            if obj.data.type == "AREA":
                warnings.append("the camera sees the light, although this is turned off")
            elif obj.data.type == "SUN" and obj.data.angle > 1e-4 or obj.data.type == "POINT" and obj.data.shadow_soft_size > 1e-6:
                warnings.append("its shadows are sharp, because it is in view and hidden from the camera")
    return warnings


def missing_libraries():
    """Yields (name, consequence) for each linked file that is missing."""
    for library in bpy.data.libraries:
        path = bpy.path.abspath(library.filepath, library=library.parent)
        if not library.packed_file and not os.path.isfile(path):
            yield library.name, f"the file {path} is missing; the data linked from it is not rendered"


def of_scene(scene):
    """Returns a list of (name, difference from Blender), without duplicates."""
    lines, materials_seen = list(missing_libraries()), {}
    for obj in scene.objects:
        if obj.hide_render:
            continue
        lines += [(obj.name, line) for line in of_object(scene, obj)]
        for slot in obj.material_slots:
            if slot.material and slot.material.name_full not in materials_seen:
                materials_seen[slot.material.name_full] = of_material(slot.material)
                lines += [(slot.material.name, line) for line in materials_seen[slot.material.name_full]]
    if scene.world:
        lines += [(scene.world.name, line) for line in of_world(scene.world)]
    if scene.camera and scene.camera.type == "CAMERA":
        lens = scene.camera.data
        if lens.dof.use_dof and (lens.dof.aperture_blades or lens.dof.aperture_ratio != 1):
            lines.append((scene.camera.name, "the aperture is round; its blades and ratio are ignored"))
        if lens.dof.use_dof and lens.type == "ORTHO":
            lines.append((scene.camera.name, "depth of field is ignored for an orthographic camera"))
    if scene.render.use_motion_blur:
        lines += _of_motion(scene)
    if scene.render.pixel_aspect_x != scene.render.pixel_aspect_y:
        lines.append((scene.name, "the pixel aspect ratio is ignored; pixels are square"))
    return lines


def _of_motion(scene):
    if any(abs(point.location[1] - 1) > 1e-3 for point in scene.render.motion_blur_shutter_curve.curves[0].points if 0.1 < point.location[0] < 0.9):
        yield scene.name, "the shutter curve is ignored"
    for obj in scene.objects:
        if not getattr(getattr(obj, "cycles", None), "use_motion_blur", True):
            yield obj.name, "it has motion blur, although motion blur is turned off for it"


def store_report_warnings(scene, path):
    """Keeps the warnings of the last frame's report."""
    try:
        with open(path, encoding="utf-8") as file:
            report = json.load(file)
    except (OSError, ValueError):
        return
    lines = [w if isinstance(w, str) else w.get("message", str(w)) for w in report.get("warnings", [])]
    gltf = report.get("gltf", {})
    lines += [f"{name}: approximated" for name in map(str, gltf.get("approximated", []))]
    lines += [f"{name}: ignored" for name in map(str, gltf.get("ignored", []))]
    _from_renders[scene.name] = lines


def from_last_render(scene):
    return _from_renders.get(scene.name, [])


def for_panel(scene):
    """Like of_scene(), but cached until something changes. Returns None if the scene is too large."""
    global _dirty
    if _dirty:
        _cache.clear()
        _dirty = False
    if scene.name not in _cache:
        if len(scene.objects) > _MAX_OBJECTS:
            return None
        _cache[scene.name] = of_scene(scene)
    return _cache[scene.name]


def look_again(scene):
    _cache[scene.name] = of_scene(scene)


@bpy.app.handlers.persistent
def _changed(*_):
    global _dirty
    _dirty = True


def register():
    bpy.app.handlers.depsgraph_update_post.append(_changed)
    bpy.app.handlers.load_post.append(_changed)


def unregister():
    bpy.app.handlers.depsgraph_update_post.remove(_changed)
    bpy.app.handlers.load_post.remove(_changed)
