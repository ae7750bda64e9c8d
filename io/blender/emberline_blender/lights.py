"""Exports Blender's lights: as KHR_lights_punctual if they have no size, otherwise as emissive meshes.

Units match Cycles: a point light of P watts has radiant intensity P / 4 pi, an area light of size A has
radiance P / 4 A (P / pi A since Blender 4), and a sun of strength E gives irradiance E. One candela in the
file is a radiant intensity of 1.
"""
import math

from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

from . import versions

_STEPS = 48  # segments of a circle
# A sun with an angle is a disc at this distance, in scene radii. At a point that is one scene radius off the centre,
# its direction is wrong by 1/1000 rad.
_SUN_RADII = 1000.0


def colour(light):
    """Returns the radiance, intensity or irradiance per watt: the light's colour, including simple nodes."""
    rgb = [light.color[i] for i in range(3)]
    if getattr(light, "use_temperature", False):
        rgb = [a * b for a, b in zip(rgb, light.temperature_color)]
    factor = 2.0 ** getattr(light, "exposure", 0.0)
    emission = emission_node(light)
    if emission:
        factor *= emission.inputs["Strength"].default_value
        rgb = [a * b for a, b in zip(rgb, emission.inputs["Color"].default_value)]
    return [max(c * factor, 0.0) for c in rgb]


def _unnormalized(light):
    """Returns a factor for the power if "Normalize" is off, as measured in Cycles 5.2. add() handles area lights."""
    if getattr(light, "normalize", True) or light.type == "AREA":
        return 1.0
    if light.type == "SUN":
        return math.pi * math.tan(light.angle / 2) ** 2 if light.angle > 0 else 1.0
    return 4 * math.pi * light.shadow_soft_size**2 if light.shadow_soft_size > 0 else 4.0


def active_surface_node(tree, output):
    """Returns the node that is connected to the surface of the tree's active output of type `output`, or None."""
    for node in tree.nodes if tree else ():
        if node.type == output and node.is_active_output and node.inputs["Surface"].is_linked:
            return node.inputs["Surface"].links[0].from_node
    return None


def emission_node(light):
    """Returns the Emission node if it is connected directly to the light's output, or else None."""
    source = active_surface_node(light.node_tree, "OUTPUT_LIGHT") if light.use_nodes else None
    return source if source and source.type == "EMISSION" else None


def in_view(scene, camera, light, placed):
    """Whether a light at `placed` (matrix_world) is in the camera's view, with a margin, and shines towards it."""
    if not camera or camera.type != "CAMERA" or camera.data.type == "PANO":
        return False
    at = placed.translation
    if light.type == "SUN":
        at = camera.matrix_world.translation + 1e4 * placed.to_3x3().col[2].normalized()
    elif light.type == "AREA" and placed.to_3x3().col[2].dot(camera.matrix_world.translation - at) > 0:
        return False
    projected = world_to_camera_view(scene, camera, Vector(at))
    return projected.z > 0 and -0.2 < projected.x < 1.2 and -0.2 < projected.y < 1.2


def _scaled(rgb, factor):
    return [c * factor for c in rgb]


def _circle(x, y):
    angles = [2 * math.pi * i / _STEPS for i in range(_STEPS)]
    return [(x * math.cos(a), y * math.sin(a), 0.0) for a in angles]


def _fan(points):
    """Returns triangles that face down, the direction in which Blender's lights shine."""
    return [(0, i + 1, i) for i in range(1, len(points) - 1)]


def _area_of(points):
    return 0.5 * abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1])))


def _sphere(radius):
    """Returns an octahedron that is subdivided three times: 512 triangles."""
    points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(3):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                m = [p + q for p, q in zip(points[a], points[b])]
                length = math.sqrt(sum(c * c for c in m))
                middles[key] = len(points)
                points.append(tuple(c / length for c in m))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = finer
    return [tuple(radius * c for c in p) for p in points], faces


def _triangle_area(points, face):
    a, b, c = (points[i] for i in face)
    u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
    cross = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return 0.5 * math.sqrt(sum(x * x for x in cross))


def _shape(light):
    if light.shape in ("DISK", "ELLIPSE"):
        return _circle(light.size / 2, (light.size if light.shape == "DISK" else light.size_y) / 2)
    x, y = light.size / 2, (light.size if light.shape == "SQUARE" else light.size_y) / 2
    return [(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)]


def add(glb, animation, name, light, track, centre, radius, hidden_from_camera):
    """Adds a light that moves along `track` (its matrix_world at each moment). Returns the node's index, or None if the
    light emits nothing. `centre` and `radius` are those of the scene.

    `name` is also the name of the light-group layer. If `hidden_from_camera`, the light is in the camera's view but
    must be invisible; a point light or sun is then exported without a size.
    """
    rgb = _scaled(colour(light), light.energy * _unnormalized(light))
    if max(rgb) <= 0:
        return None
    rotations = [m.to_3x3().normalized().to_4x4() for m in track]
    at = [Matrix.Translation(m.translation) for m in track]

    def emitter(points, faces, radiance, places):
        return animation.node(places, name=name, mesh=glb.add_emitter(name, [_gl(p) for p in points], faces, radiance))

    if light.type == "AREA":
        outline = _shape(light)
        axes = track[len(track) // 2].to_3x3()
        area = _area_of(outline) * axes.col[0].cross(axes.col[1]).length
        if area <= 0:
            return None
        size = area if getattr(light, "normalize", True) else 1.0
        # Cycles divides by the area of the exact shape. We divide by the polygon's area, which keeps the emitted power.
        return emitter(outline, _fan(outline), _scaled(rgb, versions.AREA_RADIANCE / size), track)
    if light.type == "SUN" and light.angle > 1e-4 and not hidden_from_camera:
        half = min(light.angle, math.radians(170)) / 2
        distance = _SUN_RADII * radius
        outline = _circle(distance * math.tan(half), distance * math.tan(half))
        # The cosine at a surface that faces the centre of Cycles' disc, averaged over the disc.
        mean = 2 * (1 / math.cos(half) - 1) / math.tan(half) ** 2
        radiance = _scaled(rgb, mean / (math.pi * math.sin(half) ** 2))
        far = [Matrix.Translation(centre) @ r @ Matrix.Translation((0, 0, distance)) for r in rotations]
        return emitter(outline, _fan(outline), radiance, far)
    if light.type == "POINT" and light.shadow_soft_size > 1e-6 and not hidden_from_camera:
        points, faces = _sphere(light.shadow_soft_size)
        area = sum(_triangle_area(points, f) for f in faces)
        return emitter(points, faces, _scaled(rgb, 1 / (math.pi * area)), at)
    intensity = 1.0 if light.type == "SUN" else 1 / (4 * math.pi)
    # In glTF and in Blender, lights shine along their node's -Z. axes() would turn that axis; the rotation undoes the
    # turn.
    places = [a @ r @ Matrix.Rotation(-math.pi / 2, 4, "X") for a, r in zip(at, rotations)]
    shining = {"light": _punctual(glb, name, light, _scaled(rgb, intensity))}
    return animation.node(places, name=name, extensions={"KHR_lights_punctual": shining})


def _gl(p):
    return (p[0], p[2], -p[1])


def _punctual(glb, name, light, rgb):
    peak = max(rgb)
    entry = {"name": name, "color": [c / peak for c in rgb], "intensity": peak}
    entry["type"] = {"SUN": "directional", "POINT": "point", "SPOT": "spot"}[light.type]
    if light.type == "SPOT":
        outer = min(light.spot_size / 2, math.pi / 2 - 1e-4)
        # Towards its edge, a Cycles spot fades as t^2 (3 - 2 t), but a glTF spot fades as t^2. If the glTF spot fades
        # over 3/4 of the range, both emit the same amount of light.
        inner = math.acos(min(math.cos(outer) + 0.75 * light.spot_blend * (1 - math.cos(outer)), 1.0))
        entry["spot"] = {"outerConeAngle": outer, "innerConeAngle": min(inner, outer - 1e-5)}
    glb.use("KHR_lights_punctual")
    lights = glb.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    lights.append(entry)
    return len(lights) - 1
