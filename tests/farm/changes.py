"""Only the frame that a checkpoint belongs to can resume it. A refusal names every difference between the frames.

Between a stopped run and the next run, this test changes a setting or a file. If the change affects the bits, the next
run must refuse: exit with 3, print one line that names each difference, and write nothing. Otherwise it must finish
with the right bits. The test also saves checkpoints of every estimator at many moments, which the next run must accept.
To run one case, give its name or a part of its name:

  changes.py build/release/bin/emberline scenes --only 'other seed'
"""

import json
import re
import shutil
import struct
import subprocess
import zlib

from farm import CHANNELS, EXIT_DONE, EXIT_INPUT, EXIT_STOPPED, LONG, Farm, contents, pixels
from records import parsed_file

SIZE = ["--size", "48x36"]
FRAME = ["--bucket-size", "6", "--threads", "2", "--quiet", *CHANNELS]
RESUME = ["--resume", "--checkpoint", "c", "--checkpoint-interval", "0.1", "--report", "report.json"]
# Each case has a name, additional settings of the first run, additional settings of the second run, and what the
# refusal must name. If the list of names is empty, the second run must accept the checkpoint.
SETTINGS = (
    ("other spp", "--spp 256", "--spp 255", ["--spp: 256 (now 255)"]),
    ("no spp", "--spp 256", "", ["--spp: 256 (now"]),
    ("other seed", "--spp 256", "--spp 256 --seed 1", ["--seed: 0 (now 1)"]),
    ("static noise", "--spp 256", "--spp 256 --static-noise", ["--static-noise"]),
    ("other sampler", "--spp 256", "--spp 256 --sampler stratified", ["--sampler: sobol (now stratified)"]),
    ("other channels", "--spp 256", "--spp 256 --aov variance", ["--aov: ", "(now variance)"]),
    ("time channel", "--spp 256", "--spp 256 --aov variance,albedo,N,Z,id,stop,time", ["--aov: "]),
    ("other size", "--spp 256", "--spp 256 --size 48x37", ["--size: 48x36 (now 48x37)"]),
    ("a crop", "--spp 256", "--spp 256 --crop 0,0,48,35", ["--crop: not given (now 0,0,48,35)"]),
    ("no crop", "--spp 256 --crop 0,0,40,35", "--spp 256", ["--crop: 0,0,40,35 (now not given)"]),
    ("other driver", "--spp 256", "--spp 256 --driver bisection", ["--driver: bucket (now bisection)"]),
    ("adaptive then bucket", "--spp 256 --driver adaptive", "--spp 256 --driver bucket", ["--driver: adaptive (now bucket)"]),
    ("other estimator", "--spp 256 --driver adaptive", "--spp 256 --driver adaptive --estimator two-stream", ["--estimator: nested (now two-stream)"]),
    ("other allocation", "--spp 256 --driver adaptive", "--spp 256 --driver adaptive --allocation mse", ["--allocation: display (now mse)"]),
    ("other channels judged", "--spp 256 --driver adaptive", "--spp 256 --driver adaptive --judge RGB,A", ["--judge"]),
    ("unbiased", "--spp 256 --driver adaptive", "--spp 256 --driver adaptive --unbiased", ["--unbiased"]),
    ("other axis", "--spp 256 --driver bisection", "--spp 256 --driver bisection --bisection-axis rows", ["--bisection-axis: both (now rows)"]),
    ("a threshold", "--spp 256", "--spp 256 --noise-threshold 0.001", ["--noise-threshold"]),
    ("other bucket size", "--spp 256", "--spp 256 --bucket-size 13", ["--bucket-size: 6 (now 13)"]),
    ("bucket order of a part", "--spp 256 --part 1/2", "--spp 256 --part 1/2 --bucket-order random", ["--bucket-order"]),
    ("other filter", "--spp 256", "--spp 256 --filter box", ["--filter: blackman-harris (now box)"]),
    ("filter radius", "--spp 256", "--spp 256 --filter-radius 1.5", ["--filter-radius"]),
    ("other depth", "--spp 256", "--spp 256 --max-depth 3", ["--max-depth: 16 (now 3)"]),
    ("guided paths", "--spp 256", "--spp 256 --guiding on", ["--guiding"]),
    ("other integrator", "--spp 256", "--spp 256 --integrator direct", ["--integrator: path (now direct)"]),
    ("other view", "--spp 256", "--spp 256 --look-from 0,1,4 --look-at 0,1,0", ["--look-from", "--look-at"]),
    ("field of view", "--spp 256", "--spp 256 --fov-y 33", ["--fov-y"]),
    ("a lens", "--spp 256", "--spp 256 --f-stop 4 --focus-distance 3", ["--f-stop", "--focus-distance"]),
    ("streams", "--spp 256", "--spp 256 --streams 2", ["--streams"]),
    ("light groups", "--spp 256", "--spp 256 --light-groups", ["--light-groups"]),
    ("a plane", "--spp 256", "--spp 256 --catcher-plane 0", ["--catcher-plane"]),
    ("backfaces", "--spp 256", "--spp 256 --backfaces show", ["--backfaces: cull (now show)"]),
    ("transparent", "--spp 256", "--spp 256 --transparent", ["--transparent"]),
    ("an environment", "--spp 256", "--spp 256 --env dusk.hdr", ["--env"]),
    ("no environment", "--spp 256 --env dusk.hdr", "--spp 256", ["--env"]),
    ("environment's strength", "--spp 256 --env dusk.hdr", "--spp 256 --env dusk.hdr --env-strength 2", ["--env-strength: 1 (now 2)"]),
    ("all at once", "--spp 256", "--spp 9 --seed 5 --driver bisection --filter box --crop 1,1,5,5",
     ["--spp: 256 (now 9)", "--seed: 0 (now 5)", "--driver: bucket (now bisection)", "--filter: ", "--crop: "]),
    ("threads", "--spp 256", "--spp 256 --threads 1", None),
    ("bucket order", "--spp 256", "--spp 256 --bucket-order random", None),
    ("time limit", "--spp 256", "--spp 256 --time-limit 1000", None),
    ("another report", "--spp 256", "--spp 256 --report other.json", None),
    ("another output", "--spp 256", "--spp 256 -o out.png", None),
    ("exposure of a png", "--spp 256", "--spp 256 -o out.png --exposure 1", None),
    ("threads, bisection", "--spp 256 --driver bisection", "--spp 256 --driver bisection --threads 1", None),
    ("threads, adaptive", "--spp 256 --driver adaptive", "--spp 256 --driver adaptive --threads 1", None),
    ("interval", "--spp 256 --driver adaptive", "--spp 256 --driver adaptive --checkpoint-interval 7", None),
    ("the default by name", "--spp 256", "--spp 256 --sampler sobol --max-depth 16 --seed 0 --filter blackman-harris", None),
)


def replaced(first, second):
    """Joins both lists. If an option may occur only once and both lists have it, the second value is used."""
    words, options = [*first, *second], {}
    for word in words:
        if re.match(r"--?[a-z]", word):
            name = word
            given = options.setdefault(name, [])
            if name not in ("-o", "--report"):
                given.clear()
        else:
            given.append(word)
    return [word for name, values in options.items()
            for word in ([name, values[0]] + [more for value in values[1:] for more in (name, value)] if values else [name])]


def stop(farm, case, folder, settings, scene, seconds=0.05):
    """Starts a run that its time limit stops in mid-frame. If it has saved nothing, tries again with more time. Returns
    whether there is a checkpoint."""
    command = [*SIZE, *FRAME, *settings, *RESUME]
    run = farm.run(folder, replaced(command, ["--time-limit", f"{seconds}"]), scene=scene)
    if run.code == EXIT_STOPPED and not parsed_file((folder / "c").read_bytes())[1]:
        return stop(farm, case, folder, settings, scene, 2 * seconds)
    return farm.check(run.code == EXIT_STOPPED and (folder / "c").exists(), case, f"should be stopped: {run}")


def settings(farm):
    for case, first, second, names in SETTINGS:
        if not farm.is_selected(case):
            continue
        folder = farm.folder(case)
        for name in ("dusk.hdr", "cornell_box.glb"):
            shutil.copy(farm.scenes / name, folder)
        kept = {"dusk.hdr", "cornell_box.glb"}
        if not stop(farm, case, folder, first.split(), "cornell_box.glb"):
            continue
        before = contents(folder)
        command = replaced([*SIZE, *FRAME, *RESUME], second.split())
        run = farm.run(folder, command, scene="cornell_box.glb")
        if names:
            farm.check_refused(run, folder, before, case, {EXIT_INPUT}, ["c: this checkpoint belongs to another frame: ", *names])
            continue
        expected, _ = farm.reference(replaced([*SIZE, *FRAME], first.split()))
        farm.check_done(run, folder, expected, case, {"report.json", "other.json", "out.png", *kept})


def png(width, height, color):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows = (b"\0" + bytes(color) * width) * height
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def write_scene(folder, name="scene.gltf"):
    """Writes a scene with an emissive, textured rectangle. The scene's buffer and its image are separate files."""
    points = [(-2, -2, -3), (2, -2, -3), (2, 2, -3), (-2, 2, -3)]
    data = b"".join(struct.pack("<3f", *p) for p in points)
    data += b"".join(struct.pack("<2f", *p) for p in ((0, 0), (1, 0), (1, 1), (0, 1)))
    data += struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    (folder / "points.bin").write_bytes(data)
    (folder / "colors.png").write_bytes(png(4, 4, (200, 100, 50)))
    (folder / name).write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1, "aspectRatio": 1.3333333}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0},
                       "emissiveFactor": [0.5, 0.5, 0.5]}],
        "textures": [{"source": 0}], "images": [{"uri": "colors.png"}],
        "buffers": [{"uri": "points.bin", "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                        {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-2, -2, -3], "max": [2, 2, -3]},
                      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}]}))


def files(farm):
    """Changes, moves or renames the scene, its files and its environment, one in each case."""

    def scene_edited(folder):
        text = (folder / "scene.gltf").read_text()
        (folder / "scene.gltf").write_text(text.replace('"emissiveFactor": [0.5, 0.5, 0.5]', '"emissiveFactor": [0.5, 0.5, 0.4]'))

    def points_edited(folder):
        data = bytearray((folder / "points.bin").read_bytes())
        data[0:4] = struct.pack("<f", -2.01)
        (folder / "points.bin").write_bytes(data)

    def environment_edited(folder):
        data = bytearray((folder / "env.hdr").read_bytes())
        data[-5] ^= 1
        (folder / "env.hdr").write_bytes(data)

    def moved(folder):
        (folder / "elsewhere").mkdir()
        for name in ("scene.gltf", "points.bin", "colors.png"):
            (folder / name).rename(folder / "elsewhere" / name)
        (folder / "elsewhere/scene.gltf").rename(folder / "elsewhere/other name.gltf")

    def touched(folder):
        for name in ("scene.gltf", "points.bin", "colors.png", "env.hdr"):
            shutil.copyfile(folder / name, folder / "copy")
            (folder / "copy").replace(folder / name)

    def environment_renamed(folder):
        (folder / "env.hdr").rename(folder / "sky.hdr")

    cases = (("scene edited", scene_edited, {}, ["the scene's files changed"]),
             ("texture edited", lambda folder: (folder / "colors.png").write_bytes(png(4, 4, (200, 100, 51))), {},
              ["the scene's files changed"]),
             ("buffer edited", points_edited, {}, ["the scene's files changed"]),
             ("environment edited", environment_edited, {}, ["the file of --env changed"]),
             ("scene moved", moved, {"scene": "elsewhere/other name.gltf"}, None),
             ("files touched", touched, {}, None),
             ("environment renamed", environment_renamed, {"env": "sky.hdr"}, None))
    for case, change, now, names in cases:
        if not farm.is_selected(case):
            continue
        folder = farm.folder(case)
        write_scene(folder)
        shutil.copy(farm.scenes / "dusk.hdr", folder / "env.hdr")
        base = ["--spp", "500"]
        reference = farm.run(folder, [*SIZE, *FRAME, *base, "--env", "env.hdr"], output="reference.exr", scene="scene.gltf")
        if not farm.check(reference.code == EXIT_DONE, case, f"{reference}"):
            continue
        expected = pixels(folder / "reference.exr")
        (folder / "reference.exr").unlink()
        stop(farm, case, folder, [*base, "--env", "env.hdr"], "scene.gltf")
        change(folder)
        before = contents(folder)
        run = farm.run(folder, [*SIZE, *FRAME, *base, "--env", now.get("env", "env.hdr"), *RESUME],
                       scene=now.get("scene", "scene.gltf"))
        if names:
            farm.check_refused(run, folder, before, case, {EXIT_INPUT}, names)
        else:
            farm.check_done(run, folder, expected, case, {"report.json", *before})


def environment_of_edits(farm):
    """Changes an environment that the --edits file names."""
    case = "environment of edits"
    if not farm.is_selected(case):
        return
    folder = farm.folder(case)
    write_scene(folder)
    shutil.copy(farm.scenes / "dusk.hdr", folder / "env.hdr")
    (folder / "look.json").write_text('{"emberline_edits": 1, "environment": {"file": "env.hdr"}}')
    base = ["--spp", "500", "--edits", "look.json"]
    stop(farm, case, folder, base, "scene.gltf")
    data = bytearray((folder / "env.hdr").read_bytes())
    data[-5] ^= 1
    (folder / "env.hdr").write_bytes(data)
    before = contents(folder)
    run = farm.run(folder, [*SIZE, *FRAME, *base, *RESUME], scene="scene.gltf")
    farm.check_refused(run, folder, before, case, {EXIT_INPUT}, ["the environment of --edits changed"])


def many_light_groups(farm):
    """Checkpoints must work with many light groups, because they contain the light of each group."""
    for driver in ("bisection", "adaptive", "bucket"):
        case = f"many light groups of {driver}"
        if not farm.is_selected(case):
            continue
        folder = farm.folder(case)
        write_scene(folder)
        scene = json.loads((folder / "scene.gltf").read_text())
        lights = 40
        scene["extensionsUsed"] = ["KHR_lights_punctual"]
        scene["extensions"] = {"KHR_lights_punctual": {"lights": [
            {"type": "point", "name": f"lamp {i}", "intensity": 1 + i} for i in range(lights)]}}
        for i in range(lights):
            scene["scenes"][0]["nodes"].append(len(scene["nodes"]))
            scene["nodes"].append({"extensions": {"KHR_lights_punctual": {"light": i}}, "translation": [i / 20 - 1, 0, -1]})
        (folder / "scene.gltf").write_text(json.dumps(scene))
        base = [*SIZE, *FRAME, "--spp", "300", "--driver", driver, "--light-groups"]
        expected, _ = farm.reference(base, scene=folder / "scene.gltf")
        stop(farm, case, folder, base[len([*SIZE, *FRAME]) :], "scene.gltf")
        run = farm.run(folder, [*base, *RESUME], scene="scene.gltf")
        farm.check_done(run, folder, expected, case, {"report.json", "scene.gltf", "points.bin", "colors.png"})


def names_of(program, option):
    text = subprocess.run([program, "render", "--help-all"], check=True, capture_output=True, text=True).stdout
    found = re.search(rf"\n *{option} NAME.*\n((?: {{6,}}.*\n)+)", text)
    return re.findall(r"^ {8}([\w-]+): ", found[1], re.MULTILINE)


def own_checkpoints(farm):
    """Stops frames of every estimator, with a budget and with a threshold, every few hundredths of a second. No run may
    refuse the checkpoint of the run before it."""
    budgets = ("--spp 48", "--noise-threshold 0.03 --max-spp 96", "--spp 32 --noise-threshold 0.03 --streams 2")
    for estimator in names_of(farm.program, "--estimator"):
        for budget in budgets:
            case = f"own checkpoint of {estimator} {budget}"
            if not farm.is_selected(case):
                continue
            chosen = [*SIZE, *FRAME, "--driver", "adaptive", "--estimator", estimator, *budget.split()]
            folder = farm.folder(case)
            run = farm.run(folder, chosen)
            if run.code:  # this estimator does not work with these settings
                continue
            expected = pixels(folder / "out.exr")
            shutil.rmtree(folder)
            folder.mkdir()
            for i in range(12 if LONG else 8):
                run = farm.run(folder, [*chosen, *RESUME, "--time-limit", f"{0.01 + 0.004 * (i % 5):.3f}"])
                left = (folder / "c").exists()
                if not farm.check(run.code == (EXIT_STOPPED if left else EXIT_DONE), case, f"run {i}: {run}") or not left:
                    break
            if run.code == EXIT_STOPPED:
                run = farm.run(folder, [*chosen, *RESUME])
            farm.check_done(run, folder, expected, case, {"report.json"})


def main():
    farm = Farm(__doc__, part=("", "run only this part: settings, files or own"))
    for name, part in (("settings", settings), ("files", files), ("own", own_checkpoints)):
        if name.startswith(farm.options.part):
            part(farm)
    if "files".startswith(farm.options.part):
        environment_of_edits(farm)
        many_light_groups(farm)
    farm.done()


main()
