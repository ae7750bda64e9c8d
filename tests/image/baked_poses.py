"""Compares animated files with the same pose baked into plain vertices: the pictures must agree up to rounding. Run by
hand:

  baked_poses.py EMBERLINE SCENE [--animation INDEX] [--times 0,0.3,1] [--keep FOLDER]

The poses are evaluated here in plain Python from the specification alone: appendix C, skins of section 3.7.3.3, morph
targets of 3.7.2.2. Each pose is written as a separate scene whose nodes have no transforms, and is rendered from the
same view as emberline's pose. The exit code is 1 if some pictures differ.
"""

import argparse
import bisect
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

COMPONENTS = {5120: ("b", 127), 5121: ("B", 255), 5122: ("h", 32767), 5123: ("H", 65535), 5125: ("I", 0), 5126: ("f", 0)}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
IDENTITY = [[float(r == c) for c in range(4)] for r in range(4)]


class File:
    """A .gltf or .glb: its JSON and its buffers."""

    def __init__(self, path):
        data = path.read_bytes()
        chunk = None
        if data[:4] == b"glTF":
            size = struct.unpack_from("<I", data, 12)[0]
            self.json = json.loads(data[20 : 20 + size])
            chunk = data[28 + size :]
        else:
            self.json = json.loads(data)
        self.buffers = [(path.parent / b["uri"]).read_bytes() if "uri" in b else chunk
                        for b in self.json.get("buffers", [])]

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start : start + view["byteLength"]], view.get("byteStride")

    def elements(self, index):
        """Returns the elements of an accessor as tuples of floats, with sparse elements filled in."""
        accessor = self.json["accessors"][index]
        code, largest = COMPONENTS[accessor["componentType"]]
        layout = struct.Struct(f"<{WIDTHS[accessor['type']]}{code}")
        scale = largest if accessor.get("normalized") else 0

        def read(view, offset, count, stride=None):
            data, own = self.view(view)
            stride = own or layout.size
            raw = (layout.unpack_from(data, offset + i * stride) for i in range(count))
            return [tuple(max(c / scale, -1.0) for c in e) if scale else tuple(map(float, e)) for e in raw]

        if "bufferView" in accessor:
            values = read(accessor["bufferView"], accessor.get("byteOffset", 0), accessor["count"])
        else:
            values = [(0.0,) * WIDTHS[accessor["type"]]] * accessor["count"]
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            kind = COMPONENTS[sparse["indices"]["componentType"]][0]
            data, _ = self.view(sparse["indices"]["bufferView"])
            where = struct.unpack_from(f"<{sparse['count']}{kind}", data, sparse["indices"].get("byteOffset", 0))
            what = read(sparse["values"]["bufferView"], sparse["values"].get("byteOffset", 0), sparse["count"])
            for i, value in zip(where, what):
                values[i] = value
        return values


# ---- appendix C


def slerp(a, b, t):
    d = sum(x * y for x, y in zip(a, b))
    angle, sign = math.acos(min(abs(d), 1.0)), 1.0 if d >= 0 else -1.0
    if angle < 1e-6:
        return [(1 - t) * x + sign * t * y for x, y in zip(a, b)]
    wa, wb = math.sin(angle * (1 - t)) / math.sin(angle), sign * math.sin(angle * t) / math.sin(angle)
    return [wa * x + wb * y for x, y in zip(a, b)]


def sampled(times, values, interpolation, path, time):
    """Returns the value at `time`. `values` has one list of numbers for each key, or three for each key of a spline."""
    spline = interpolation == "CUBICSPLINE"
    value = lambda k: values[3 * k + 1] if spline else values[k]
    k = bisect.bisect_right(times, time) - 1
    if k < 0 or k + 1 == len(times) or times[k] == time or interpolation == "STEP":
        return list(value(max(k, 0)))
    duration = times[k + 1] - times[k]
    t = (time - times[k]) / duration
    if spline:
        b, a = values[3 * k + 2], values[3 * k + 3]
        return [(2 * t**3 - 3 * t**2 + 1) * v0 + duration * (t**3 - 2 * t**2 + t) * b0
                + (-2 * t**3 + 3 * t**2) * v1 + duration * (t**3 - t**2) * a1
                for v0, b0, a1, v1 in zip(value(k), b, a, value(k + 1))]
    if path == "rotation":
        return slerp(value(k), value(k + 1), t)
    return [(1 - t) * x + t * y for x, y in zip(value(k), value(k + 1))]


def pose_nodes(file, animation, time):
    """Writes the animation's values into the nodes."""
    for channel in animation["channels"]:
        target, sampler = channel["target"], animation["samplers"][channel["sampler"]]
        if "node" not in target:
            continue
        times = [t[0] for t in file.elements(sampler["input"])]
        values = file.elements(sampler["output"])
        interpolation = sampler.get("interpolation", "LINEAR")
        if target["path"] == "weights":
            width = len(values) // len(times) // (3 if interpolation == "CUBICSPLINE" else 1)
            flat = [v[0] for v in values]
            values = [flat[i : i + width] for i in range(0, len(flat), width)]
        file.json["nodes"][target["node"]][target["path"]] = sampled(
            times, values, interpolation, target["path"], time)


# ---- matrices of column vectors


def product(a, b):
    return [[sum(a[r][k] * b[k][c] for k in range(4)) for c in range(4)] for r in range(4)]


def local(node):
    if "matrix" in node:
        return [[node["matrix"][4 * c + r] for c in range(4)] for r in range(4)]
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    length = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / length, y / length, z / length, w / length
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    scale, move = node.get("scale", (1, 1, 1)), node.get("translation", (0, 0, 0))
    return [[turn[r][c] * scale[c] for c in range(3)] + [move[r]] for r in range(3)] + [[0, 0, 0, 1]]


def world_matrices(nodes):
    parents = {child: i for i, node in enumerate(nodes) for child in node.get("children", ())}
    known = {}

    def world(i):
        if i not in known:
            own = local(nodes[i])
            known[i] = product(world(parents[i]), own) if i in parents else own
        return known[i]

    return [world(i) for i in range(len(nodes))]


def point(m, p):
    return [m[r][0] * p[0] + m[r][1] * p[1] + m[r][2] * p[2] + m[r][3] for r in range(3)]


def direction(m, v):
    out = [m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2] for r in range(3)]
    length = math.sqrt(sum(c * c for c in out))
    return [c / length for c in out] if length else out


def normal(m, n):
    """Transforms a normal with the cofactor matrix, which is the inverse transpose up to a factor."""
    c = [[m[(r + 1) % 3][(s + 1) % 3] * m[(r + 2) % 3][(s + 2) % 3]
          - m[(r + 1) % 3][(s + 2) % 3] * m[(r + 2) % 3][(s + 1) % 3] for s in range(3)] + [0] for r in range(3)]
    sign = 1 if sum(m[0][s] * c[0][s] for s in range(3)) >= 0 else -1
    return [sign * x for x in direction(c, n)]


# ---- baking


def morphed(file, primitive, name, weights):
    values = [list(v) for v in file.elements(primitive["attributes"][name])]
    for weight, target in zip(weights, primitive.get("targets", ())):
        if weight and name in target:
            for value, delta in zip(values, file.elements(target[name])):
                for c, d in enumerate(delta):
                    value[c] += weight * d
    return values


def matrices(file, node, primitive, worlds, count):
    """Returns the matrix from each vertex to the world."""
    if "skin" not in node[1]:
        return [worlds[node[0]]] * count
    skin = file.json["skins"][node[1]["skin"]]
    binds = [[[m[4 * c + r] for c in range(4)] for r in range(4)] for m in
             (file.elements(skin["inverseBindMatrices"]) if "inverseBindMatrices" in skin else [])]
    joints = [product(worlds[j], binds[i] if binds else IDENTITY) for i, j in enumerate(skin["joints"])]
    attributes, sums = primitive["attributes"], []
    indices, weights = file.elements(attributes["JOINTS_0"]), file.elements(attributes["WEIGHTS_0"])
    for index, weight in zip(indices, weights):
        whole = sum(weight)
        sums.append([[sum(w / whole * joints[int(j)][r][c] for j, w in zip(index, weight) if w) for c in range(4)]
                     for r in range(4)])
    return sums


def baked_primitive(file, node, primitive, worlds, weights, add):
    attributes = primitive["attributes"]
    positions = morphed(file, primitive, "POSITION", weights)
    each = matrices(file, node, primitive, worlds, len(positions))
    result = {k: v for k, v in primitive.items() if k not in ("attributes", "targets")}
    result["attributes"] = {k: v for k, v in attributes.items() if not k.startswith(("JOINTS", "WEIGHTS"))}
    result["attributes"]["POSITION"] = add([point(m, p) for m, p in zip(each, positions)], "VEC3")
    if "NORMAL" in attributes:
        values = morphed(file, primitive, "NORMAL", weights)
        result["attributes"]["NORMAL"] = add([normal(m, n) for m, n in zip(each, values)], "VEC3")
    if "TANGENT" in attributes:
        values = morphed(file, primitive, "TANGENT", weights)
        result["attributes"]["TANGENT"] = add([direction(m, t) + [t[3]] for m, t in zip(each, values)], "VEC4")
    return result


def bake(file, path):
    """Writes the file with transforms, skins and morph targets baked into the vertices. Returns the bounds."""
    data, root = bytearray(), dict(file.json)
    low, high = [math.inf] * 3, [-math.inf] * 3
    root["accessors"], root["bufferViews"] = list(root["accessors"]), list(root["bufferViews"])

    def add(values, kind):
        root["bufferViews"].append({"buffer": len(file.buffers), "byteOffset": len(data),
                                    "byteLength": 4 * len(values) * len(values[0])})
        root["accessors"].append({"bufferView": len(root["bufferViews"]) - 1, "componentType": 5126,
                                  "count": len(values), "type": kind})
        for value in values:
            data.extend(struct.pack(f"<{len(value)}f", *value))
        return len(root["accessors"]) - 1

    worlds, meshes, nodes = world_matrices(root["nodes"]), [], []
    for i, node in enumerate(root["nodes"]):
        if "mesh" not in node:
            continue
        mesh = root["meshes"][node["mesh"]]
        weights = node.get("weights", mesh.get("weights", ()))
        primitives = [baked_primitive(file, (i, node), p, worlds, weights, add) for p in mesh["primitives"]]
        for p in primitives:
            view = root["bufferViews"][root["accessors"][p["attributes"]["POSITION"]]["bufferView"]]
            values = struct.unpack_from(f"<{view['byteLength'] // 4}f", data, view["byteOffset"])
            for c in range(3):
                low[c], high[c] = min(low[c], *values[c::3]), max(high[c], *values[c::3])
        meshes.append({"primitives": primitives})
        nodes.append({"mesh": len(nodes)})
    for name in ("animations", "skins", "cameras"):
        root.pop(name, None)
    root.update(meshes=meshes, nodes=nodes, scene=0, scenes=[{"nodes": list(range(len(nodes)))}])
    root["buffers"] = []
    for i, buffer in enumerate([*file.buffers, bytes(data)]):
        (path.parent / f"{path.stem}.{i}.bin").write_bytes(buffer)
        root["buffers"].append({"uri": f"{path.stem}.{i}.bin", "byteLength": len(buffer)})
    path.write_text(json.dumps(root))
    return low, high


# ---- pictures


def run(*words):
    return subprocess.run([str(w) for w in words], check=True, capture_output=True, text=True).stdout


def compare_pose(program, scene, animation, time, folder):
    """Returns the RMSE of normals and of radiance between the posed and the baked picture."""
    file = File(scene)
    pose_nodes(file, file.json["animations"][animation], time)
    for image in file.json.get("images", ()):
        if "uri" in image and not image["uri"].startswith("data:"):
            (folder / image["uri"]).write_bytes((scene.parent / image["uri"]).read_bytes())
    name = f"{scene.stem}.{animation}.{time:g}"
    baked = folder / f"{name}.baked.gltf"
    low, high = bake(file, baked)
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    size = math.dist(low, high)
    eye = [m + size * d for m, d in zip(middle, (0.9, 0.5, 1.1))]
    view = ["--look-from", ",".join(map(str, eye)), "--look-at", ",".join(map(str, middle)), "--fov-y", 40,
            "--size", "320x240", "--spp", 16, "--quiet"]
    errors = []
    for integrator in ("normal", "path"):
        pictures = [folder / f"{name}.{integrator}.{which}.exr" for which in ("posed", "baked")]
        how = [*view, "--integrator", integrator, "-o"]
        run(program, "render", scene, "--animation", animation, "--time", time, *how, pictures[0])
        run(program, "render", baked, *how, pictures[1])
        errors.append(json.loads(run(program, "compare", *pictures, "--json"))["mse"] ** 0.5)
    return errors


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("--animation", type=int, default=0)
    parser.add_argument("--times", default="0,0.3,1")
    parser.add_argument("--keep", type=pathlib.Path, help="pictures and baked scenes stay in this folder")
    parser.add_argument("--most", type=float, default=0.01, help="RMSE that counts as rounding [0.01]")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        differ = 0
        for time in map(float, options.times.split(",")):
            errors = compare_pose(options.program, options.scene, options.animation, time, folder)
            differ += max(errors) > options.most
            print(f"{options.scene.name} animation {options.animation} at {time:g} s: "
                  f"RMSE of normals {errors[0]:.2g}, of light {errors[1]:.2g}")
    sys.exit(differ > 0)


if __name__ == "__main__":
    main()
