"""Motion blur: evaluates the scene at moments while the shutter is open, and writes the motion as an animation."""
import math

from mathutils import Matrix

from . import versions
from .glb import axes, flat

# Render options for the exported animation, which lasts one second. The shutter is open for all of it.
OPTIONS = ["--time", "0", "--fps", "1", "--shutter", "0,1"]


class Shutter:
    """The shutter of an F12 render by `engine`. Moving the scene to another time updates the engine's depsgraph."""

    def __init__(self, engine, scene):
        self._engine = engine
        self._frame = scene.frame_current + scene.frame_subframe
        length = scene.render.motion_blur_shutter
        start = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[versions.shutter_owner(scene).motion_blur_position]
        intervals = 2**scene.emberline.motion_steps
        self.times = [i / intervals for i in range(intervals + 1)]  # as fractions of the shutter interval
        self._frames = [self._frame + length * (start + t) for t in self.times]
        self.middle = intervals // 2

    def moments(self):
        """Sets the scene to each of `times`, the middle one first, and yields its index. Finally restores the frame."""
        order = [self.middle] + [i for i in range(len(self.times)) if i != self.middle]
        try:
            for i in order:
                self._go_to(self._frames[i])
                yield i
        finally:
            self._go_to(self._frame)

    def _go_to(self, frame):
        whole = math.floor(frame)
        self._engine.frame_set(whole, subframe=frame - whole)


class Animation:
    """Adds static and moving nodes to a file. `times` has the time of each matrix of a track; it is empty without a
    shutter."""

    def __init__(self, glb, times=()):
        self._glb, self._times = glb, times
        self._input = None

    @property
    def empty(self):
        return self._input is None

    def node(self, track, morphs=0, **members):
        """Adds a node that moves along `track` (Blender matrices). Returns its index, or None if a matrix is not
        finite. `morphs` is the number of morph targets of its mesh: one for each time except the middle, or none."""
        placed = [axes(m) for m in track]
        if not all(math.isfinite(x) for m in placed for row in m for x in row):
            return None
        middle = placed[len(placed) // 2]
        if all(m == middle for m in placed):
            leaf = root = self._glb.add("nodes", {**members, "matrix": flat(middle)})
        else:
            leaf, root = self._moving(placed, middle, members)
        if morphs:
            poses = [[float(i == k) for k in range(morphs + 1) if k != morphs // 2] for i in range(morphs + 1)]
            self._channel({"node": leaf, "path": "weights"}, [w for pose in poses for w in pose])
        return root

    def _moving(self, placed, middle, members):
        parts = [m.decompose() for m in placed]
        leaf = None
        if any(_differ(Matrix.LocRotScale(*part), m) for part, m in zip(parts, placed)):
            # There is shear. The leaf keeps the middle moment's matrix, and a parent rotates and scales the leaf about
            # its origin.
            middle_matrix = middle.to_3x3()
            leaf = self._glb.add("nodes", {**members, "matrix": flat(middle_matrix.to_4x4())})
            members = {"children": [leaf]}
            inverse = middle_matrix.inverted_safe()
            parts = [(Matrix.Translation(m.translation) @ (m.to_3x3() @ inverse).to_4x4()).decompose() for m in placed]
        for before, (_, turned, _) in zip(parts, parts[1:]):
            turned.make_compatible(before[1])
        place, turned, scale = ([list(part[i]) for part in parts] for i in range(3))
        turned = [[x, y, z, w] for w, x, y, z in turned]
        root = self._glb.add("nodes", members)
        for path, values in (("translation", place), ("rotation", turned), ("scale", scale)):
            self._glb.json["nodes"][root][path] = values[len(values) // 2]
            if any(v != values[0] for v in values):
                self._channel({"node": root, "path": path}, values)
        return root if leaf is None else leaf, root

    def animate_value(self, pointer, values):
        """Animates the value at `pointer` in the file's JSON. `values` has one value per time."""
        self._glb.use("KHR_animation_pointer")
        self._channel({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}, values)

    def _channel(self, target, values):
        if self._input is None:
            self._input = self._glb.add_vectors(self._times, bounds=True)
            self._glb.add("animations", {"name": "shutter", "channels": [], "samplers": []})
        animation = self._glb.json["animations"][0]
        animation["channels"].append({"sampler": len(animation["samplers"]), "target": target})
        animation["samplers"].append({"input": self._input, "output": self._glb.add_vectors(values)})


def _differ(a, b):
    size = max(abs(x) for row in b.to_3x3() for x in row)
    return any(abs(x - y) > 1e-4 * size for r, s in zip(a.to_3x3(), b.to_3x3()) for x, y in zip(r, s))
