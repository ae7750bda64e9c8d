#!/usr/bin/env python3
"""Renders glTF files next to pictures from other sources, and files of equal content in two encodings next to each other.

    tests/bench/asset_gallery.py ASSETS -o DIR [--spp N] [--size WxH] [--beside PICTURES] [--only NAME,...]

ASSETS/views.json is as in race_cycles.py. Files in ASSETS/{scenes,features,derived} without a view there get the
framing camera. ASSETS/previews.jpg is a contact sheet of scenes and features by name, five cells per row.
DIR gets NAME.exr, .png and .json (the report) of each file, and an index.html that contains all of them.
PICTURES/NAME.exr, from another renderer, adds a third column with its mean relative difference. The exit code is 1
if a render failed, or if a pair differs that must not. Needs oiiotool (Debian: openimageio-tools).
"""
import argparse
import base64
import html
import json
import pathlib
import subprocess
import sys
import tempfile

from two_builds import words_of

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FOLDERS = ("scenes", "features", "derived")
COLUMNS, CELL, CAPTION = 5, (320, 180), 16  # of the contact sheet
EXCLUDED_SCENES = {"many_cubes"}
# The scene has sunlight of 2049 lux, with an environment of about 1. It is exposed like the preview, whose renderer
# divides lights by 683.
EXPOSURE = {"mixed_lighting": -9.4}
# Pairs of equal content, and why their bits may differ. None means that the conversion is lossless, so no bit may
# differ.
QUANTISED = "16-bit positions, 8-bit normals, 12-bit texture coordinates"
PAIRS = {
    ("milk_truck_webp", "cesium_milk_truck"): None,
    ("milk_truck_ktx2_uastc", "cesium_milk_truck"): "UASTC is lossy",
    ("milk_truck_draco", "cesium_milk_truck"): "16-bit positions, 12-bit normals, 14-bit texture coordinates",
    ("milk_truck_quantized", "cesium_milk_truck"): QUANTISED,
    ("milk_truck_meshopt", "cesium_milk_truck"): QUANTISED + ", octahedral",
    ("milk_truck_meshopt", "milk_truck_quantized"): "octahedral normals",
    ("flight_helmet_meshopt", "flight_helmet"): "16-bit positions, normals and texture coordinates, 8-bit tangents",
    ("many_cubes_instanced", "many_cubes"): "385 of 501 transforms differ in their last bits",
}
PREVIEWS = """The previews look like Blender 3.4's Cycles behind its own glTF importer and Filmic view: radiance 0.11 is shown as 0.14,
1.16 as 0.50. Ours use the plain sRGB view, so bright areas are lighter and more saturated. Notes say what the specification requires."""
NOTES = {
    "sunglasses": "KHR_materials_iridescence: a film of 300 nm and index 2 on a base of index 1 is cyan, violet at grazing angles; the "
                  "preview has no film, and a base of index 1 alone reflects nothing.",
    "sheen_cloth": "KHR_materials_sheen: purple at grazing angles, the blue base scaled down by the sheen's albedo; the preview adds its "
                   "sheen to the whole base.",
    "mixed_lighting": "KHR_lights_punctual: a sun of 2049 lux makes the floor 500 cd/m2. Shown 9.4 stops darker.",
    "lights_four_kinds": "KHR_lights_punctual: a red point, green and blue spots and a cyan sun; the preview divides them by 683.",
    "ktx2_balloon": "KHR_texture_basisu: the preview has no such textures.",
    "anisotropy_strength": "KHR_materials_anisotropy: reflections grow along the horizontal tangents; the preview has no anisotropy.",
    "specular_test": "KHR_materials_specular: factor 0 reflects nothing, and a yellow colour reflects yellow; the preview ignores both.",
    "low_poly_jungle": "KHR_materials_specular: a black specular colour undoes index 1000; the preview keeps its mirror (white leaves).",
    "transmission_roughness": "KHR_materials_transmission: rough glass keeps its energy; the preview's darkens (top right).",
    "emission_strength": "emissiveTexture x emissiveFactor x emissiveStrength: all of the last eight are textured; the preview drops some.",
    "primitive_modes": "COLOR_0 multiplies the base colour: yellow; the preview ignores it where the default material is used.",
    "fox_skinned": "No animation is selected: joints are where their nodes are; the preview shows the first animation's first frame.",
    "normal_tangent": "Normal maps beside modelled domes: the highlights of each pair must agree. Ours do, the preview's do not.",
}
PAGE = """<!doctype html><meta charset="utf-8"><title>Assets</title><style>
body { font: 14px sans-serif; margin: 2em; background: #222; color: #ddd } img { width: 480px; display: block }
td, th { vertical-align: top; text-align: left; padding: 4px 10px 4px 0 } .bad { color: #f77 } h3 { margin: 1.5em 0 .3em }
</style>"""


def arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a = p.add_argument
    a("assets", type=pathlib.Path)
    a("-o", "--output", type=pathlib.Path, required=True, metavar="DIR")
    a("--emberline", default=ROOT / "build/release/bin/emberline")
    a("--spp", default="64")
    a("--size", default="480x270")
    a("--threads", default="2")
    a("--beside", type=pathlib.Path, metavar="PICTURES")
    a("--only", type=lambda text: set(text.split(",")), metavar="NAME,...", help="render only these files")
    a("--pairs", type=pathlib.Path, metavar="TABLE.md", help="write the table of pairs as Markdown")
    return p.parse_args()


def run(*words):
    return subprocess.run(list(map(str, words)), capture_output=True, text=True)


def assets_of(folder, only):
    """Lists (name, file) of each glTF file, in the order of FOLDERS, then by name."""
    files = [f for kind in FOLDERS for f in sorted((folder / kind).rglob("*.gl*"), key=lambda f: f.stem)
             if f.suffix in (".gltf", ".glb")]
    return [(f.stem, f) for f in files if only is None or f.stem in only]


def preview_cells(folder):
    """Returns {name: oiiotool arguments that cut out its cell}. Cell 7 is row 1, column 2."""
    names = sorted(f.stem for kind in FOLDERS[:2] for f in (folder / kind).rglob("*.gl*") if f.stem not in EXCLUDED_SCENES)
    width, height = CELL
    cut = lambda i: f"{width}x{height}+{i % COLUMNS * width}+{i // COLUMNS * (height + CAPTION) + CAPTION}"
    return {name: [folder / "previews.jpg", "--cut", cut(i)] for i, name in enumerate(names)}


def embedded(*words):
    """Runs oiiotool with `words` and returns the result as an <img> with embedded data."""
    with tempfile.TemporaryDirectory() as out:
        picture = pathlib.Path(out) / "a.jpg"
        subprocess.run(["oiiotool", *map(str, words), "--compression", "jpeg:88", "-d", "uint8", "-o", picture], check=True)
        return f'<img src="data:image/jpeg;base64,{base64.b64encode(picture.read_bytes()).decode()}">'


def render(options, name, file, view):
    """Returns the report, or the error as a string."""
    to, words = lambda suffix: options.output / (name + suffix), words_of(view, options.assets) if view else []
    done = run(options.emberline, "render", file, *words, "--size", options.size, "--spp", options.spp, "--threads", options.threads,
               "--exposure", EXPOSURE.get(name, 0), "--quiet", "-o", to(".exr"), "-o", to(".png"), "--report", to(".json"))
    return done.stderr.strip() or f"exit code {done.returncode}" if done.returncode else json.loads(to(".json").read_text())


def comparison(options, image, reference):
    """Returns the figures of `emberline compare`, or None if it fails."""
    done = run(options.emberline, "compare", image, reference, "--json")
    return json.loads(done.stdout) if done.returncode == 0 else None


def mean_relative_difference(image, reference):
    """Returns the mean of |a - b| / (b + 0.01) over pixels and channels, and the ratio of the means of a and b."""
    rgb = lambda picture: (picture, "--ch", "R,G,B")
    def mean(*words):
        averages = next(line for line in run("oiiotool", *words, "--printstats").stdout.splitlines() if "Stats Avg" in line)
        return sum(map(float, averages.split()[2:5])) / 3
    difference = mean(*rgb(image), *rgb(reference), "--absdiff", *rgb(reference), "--addc", "0.01", "--div")
    return difference, mean(*rgb(image)) / mean(*rgb(reference))


def format_facts(report):
    lists = {"honoured": "used", "approximated": "approximated", "ignored": "ignored"}
    rows = [(label, report["gltf"][key]) for label, key in lists.items()] + [("warnings", report["warnings"])]
    text = "".join(f"<br>{label}: {html.escape('; '.join(map(str, items)))}" for label, items in rows if items)
    return f'{report["time"]["render_cpu_s"]:.1f} processor s' + text


def section(options, name, view, report, cells):
    if isinstance(report, str):
        return f'<h3>{name}</h3><p class="bad">{html.escape(report)}'
    columns = [("Emberline", embedded(options.output / f"{name}.png"))]
    if name in cells:
        columns.append(("preview", embedded(*cells[name])))
    other = options.beside and options.beside / f"{name}.exr"
    if other and other.exists():
        difference, ratio = mean_relative_difference(options.output / f"{name}.exr", other)
        columns.append((f"other renderer: mean relative difference {difference:.3f}, our mean is {ratio:.3f} of its mean",
                        embedded(other, "--ch", "R,G,B", "--colorconvert", "linear", "sRGB")))
    notes = [NOTES.get(name, ""), "" if view else "framing camera"]
    return (f"<h3>{name}</h3><table><tr>" + "".join(f"<td>{picture}{title}" for title, picture in columns) + "</table>"
            + f"<p>{format_facts(report)}" + "".join(f"<br>{html.escape(note)}" for note in notes if note))


def pair_lines(options, rendered):
    """Returns the table of pairs, and whether bits differ that must not."""
    wrong, lines = False, ["| file | compared with | identical bits | PSNR, dB | SSIM | FLIP | pixels that differ | why |",
                           "| --- | --- | --- | ---: | ---: | ---: | ---: | --- |"]
    for (name, original), why in PAIRS.items():
        if not {name, original} <= rendered:
            continue
        c = comparison(options, options.output / f"{name}.exr", options.output / f"{original}.exr")
        wrong |= c is None or (c["different_pixels"] > 0 and why is None)
        if c is None:
            lines.append(f"| {name} | {original} | could not be compared | | | | | |")
        elif not c["different_pixels"]:
            lines.append(f"| {name} | {original} | yes | | | | 0 | |")
        else:
            lines.append(f"| {name} | {original} | no | {c['psnr']:.1f} | {c['ssim']:.5f} | {c['flip']:.5f} | "
                         f"{100 * c['different_pixels'] / (c['width'] * c['height']):.1f} % | {why or 'MUST NOT DIFFER'} |")
    return lines, wrong


def main():
    options = arguments()
    options.output.mkdir(parents=True, exist_ok=True)
    views = json.loads((options.assets / "views.json").read_text())
    cells = preview_cells(options.assets)
    reports, page = {}, [PAGE, f"<p>{PREVIEWS}"]
    for name, file in assets_of(options.assets, options.only):
        print(name, flush=True)
        view = views.get(file.relative_to(options.assets).as_posix())
        reports[name] = render(options, name, file, view)
        page.append(section(options, name, view, reports[name], cells))
    failed = [name for name, report in reports.items() if isinstance(report, str)]  # a string is an error
    lines, wrong = pair_lines(options, reports.keys() - failed)
    table = "".join("<tr><td>" + "<td>".join(html.escape(cell.strip()) for cell in line.strip("|").split("|"))
                    for line in lines if "---" not in line)
    page.append(f"<h3>Pairs</h3><table>{table}</table>")
    (options.output / "index.html").write_text("\n".join(page))
    if options.pairs:
        options.pairs.write_text("\n".join(lines) + "\n")
    for name in failed:
        print(f"asset_gallery.py: {name}: {reports[name]}", file=sys.stderr)
    return 1 if failed or wrong else 0


if __name__ == "__main__":
    sys.exit(main())
