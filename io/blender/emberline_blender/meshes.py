"""Converts Blender's meshes to meshes of a .glb with NumPy."""
import numpy

from . import versions


def _read(items, name, kind, width):
    values = numpy.empty((len(items), width), kind)
    items.foreach_get(name, values.ravel())
    return values


def _axes(vectors):
    """Converts vectors from Blender's axes to glTF's."""
    return numpy.stack((vectors[:, 0], vectors[:, 2], -vectors[:, 1]), axis=1)


class Mesh:
    """A mesh with its triangles sorted by material slot. Each of its vertices is a face corner, or stands for several
    identical corners of a Blender vertex."""

    def __init__(self, mesh, of):
        """`mesh` must be a Blender mesh with faces; `of` is the name of the instance from which it comes."""
        mesh.calc_loop_triangles()
        vertices = _read(mesh.loops, "vertex_index", numpy.int32, 1)[:, 0]
        uvs = [_read(layer.data, "uv", numpy.float32, 2) for layer in mesh.uv_layers]
        normals = versions.corner_normals(mesh)
        # The first corner of each vertex represents all corners of that vertex that are identical to it.
        first = numpy.zeros(len(mesh.vertices), numpy.int64)
        first[vertices[::-1]] = numpy.arange(len(vertices))[::-1]
        like = first[vertices]
        alike = (normals == normals[like]).all(axis=1)
        for uv in uvs:
            alike &= (uv == uv[like]).all(axis=1)
        corners = _read(mesh.loop_triangles, "loops", numpy.int32, 3)
        corners = numpy.where(alike, like, numpy.arange(len(vertices)))[corners]
        slots = numpy.zeros(len(corners), numpy.int32)
        if len(mesh.materials) > 1:
            slots = _read(mesh.loop_triangles, "material_index", numpy.int32, 1)[:, 0]
            slots = numpy.clip(slots, 0, len(mesh.materials) - 1)
        self._corner_count = len(vertices)
        self._positions = _read(mesh.vertices, "co", numpy.float32, 3)[vertices]
        self._normals, self._uvs = normals, uvs
        self.finite = bool(numpy.isfinite(self._positions).all())
        self.slots = {}  # for each slot: its vertices (as corners), and its triangles (as indices into these vertices)
        for slot in numpy.unique(slots):
            triangles = corners[slots == slot]
            used = numpy.zeros(len(vertices), bool)
            used[triangles] = True
            self.slots[int(slot)] = numpy.flatnonzero(used), (numpy.cumsum(used, dtype=numpy.uint32) - 1)[triangles]
        self.of = of
        self.used_materials = {}  # keys of the materials, by slot
        self._poses, self._changes_faces = [], False

    def add_pose(self, mesh):
        """Adds the shape of the mesh at another moment. If the topology has changed, keeps only the first shape and
        returns False."""
        if self._changes_faces or len(mesh.loops) != self._corner_count:
            self._poses, self._changes_faces = [], True
            return False
        vertices = _read(mesh.loops, "vertex_index", numpy.int32, 1)[:, 0]
        positions = _read(mesh.vertices, "co", numpy.float32, 3)[vertices]
        self._poses.append((positions - self._positions, versions.corner_normals(mesh) - self._normals))
        return True

    def add_to(self, glb, materials):
        """Adds the mesh to the file and returns its index. `materials` maps material keys to the file's indices."""
        primitives = []
        for slot, (corners, triangles) in self.slots.items():
            attributes = {
                "POSITION": glb.add_vectors(_axes(self._positions[corners]), bounds=True),
                "NORMAL": glb.add_vectors(_axes(self._normals[corners])),
            }
            for i, uv in enumerate(self._uvs):
                attributes[f"TEXCOORD_{i}"] = glb.add_vectors(numpy.float32((0, 1)) + numpy.float32((1, -1)) * uv[corners])
            primitive = {"attributes": attributes, "indices": glb.add_indices(triangles)}
            primitive["material"] = materials[self.used_materials[slot]] if slot in self.used_materials else glb.default_material()
            if self._poses:
                primitive["targets"] = [
                    {"POSITION": glb.add_vectors(_axes(p[corners]), bounds=True), "NORMAL": glb.add_vectors(_axes(n[corners]))}
                    for p, n in self._poses
                ]
            primitives.append(primitive)
        mesh = {"primitives": primitives}
        if self._poses:
            mesh["weights"] = [0] * len(self._poses)
        return glb.add("meshes", mesh)
