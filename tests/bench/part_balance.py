#!/usr/bin/env python3
"""Measures how evenly the parts of a frame are loaded. Prints the time of the slowest part divided by the mean time,
for three ways to split a frame.

    tests/bench/part_balance.py build/release/bin/emberline scenes/teapot.glb [--assets DIR SCENE...]
        [--parts 4,16,64] [--size 640x360] [--spp 8] [--bucket-size 64,32] [--check]

SCENE is a glTF file, or one below DIR, where DIR/views.json has its view (README.md, "The race").
Renders a frame on one thread with the seconds of each pixel (--aov time). This is wall time, which includes time
slices of other work. So the minimum of each pixel over --repeat renders counts; a pixel's samples are the same in
every bucket order. The sums by bucket are then split: "interleaved" as in `render --part K/N` (every N-th bucket
in Hilbert order), "blocks" of consecutive buckets in that order, and "rows" of consecutive pixel rows, as with
--crop.

--check renders the parts of two small frames and checks that the bucket numbers in their checkpoints agree with
the order that this script assumes.
"""
import argparse
import array
import itertools
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "farm"), str(HERE.parent / "invariance")]
from frame_bits import chunks  # noqa: E402
from records import TILE, parsed_file  # noqa: E402

TILE_SIDE = 64  # of the pictures that `heatmap` writes
# The first pixel that touches new memory is slower, by 12 ms for 16 pixels of a frame of 1.6 s. Each order makes
# another pixel the first one. The pixels' samples stay the same.
ORDERS = ("hilbert", "random", "spiral")

# glTF cannot name an environment; scenes/README.md says which of our scenes need one.
OWN_ENVIRONMENTS = {"roughness_spheres": "studio.hdr", "checker_plane": "dusk.hdr", "thin_wires": "dusk.hdr"}


class Scene:
    """A file, its view and light as options of `render`, and the number of bytes that a node must read."""

    def __init__(self, name, assets):
        below = assets / name if assets else None
        self.file = below if below and below.exists() else pathlib.Path(name)
        self.name, self.options, environment = self.file.stem, [], None
        if self.file == below:
            view = json.loads((assets / "views.json").read_text()).get(str(pathlib.PurePosixPath(name)), {})
            for key in ("look_from", "look_at"):
                if key in view:
                    self.options += [f"--{key.replace('_', '-')}={','.join(map(str, view[key]))}"]
            for key in ("fov_y", "env_strength"):
                if key in view:
                    self.options += [f"--{key.replace('_', '-')}", str(view[key])]
            environment = assets / view["env"] if "env" in view else None
        elif self.name in OWN_ENVIRONMENTS:
            environment = self.file.parent / OWN_ENVIRONMENTS[self.name]
        if environment:
            self.options += ["--env", str(environment)]
        self.bytes = sum(path.stat().st_size for path in [self.file, *self.files(), *filter(None, [environment])])

    def files(self):
        """Returns the files to which a .gltf refers."""
        if self.file.suffix != ".gltf":
            return []
        gltf = json.loads(self.file.read_text())
        names = {entry["uri"] for kind in ("buffers", "images") for entry in gltf.get(kind, []) if "uri" in entry}
        return [self.file.parent / name for name in names if not name.startswith("data:")]


def render(program, scene, *options):
    command = [program, "render", scene.file, *scene.options, "--quiet", *options]
    subprocess.run([str(word) for word in command], check=True)


def unpacked(data, size):
    """Decompresses OpenEXR's ZIP to `size` bytes. The format stores differences of bytes, and even bytes first."""
    if len(data) == size:
        return data
    sums = itertools.accumulate(zlib.decompress(data))
    # Each byte is the difference to the previous one, plus 128.
    moved = bytes((s - 128 * i) & 255 for i, s in enumerate(sums))
    out, half = bytearray(size), (size + 1) // 2
    out[0::2], out[1::2] = moved[:half], moved[half:]
    return bytes(out)


def one_channel(path, width, height):
    """Reads an EXR file with one float channel and the tiles of `heatmap`."""
    values = array.array("f", bytes(4 * width * height))
    for chunk in chunks(path.read_bytes()):
        column, row, _, _, size = struct.unpack_from("<5i", chunk)
        x, y = column * TILE_SIDE, row * TILE_SIDE
        across, down = min(TILE_SIDE, width - x), min(TILE_SIDE, height - y)
        tile = array.array("f", unpacked(chunk[20 : 20 + size], 4 * across * down))
        for i in range(down):
            at = (y + i) * width + x
            values[at : at + across] = tile[i * across : (i + 1) * across]
    return values


def pixel_seconds(program, scene, size, spp, repeat, folder):
    """Returns width, height and the minimum seconds of each pixel, rows from the top."""
    frame, numbers, min_seconds = folder / "frame.exr", folder / "time.exr", None
    width, height = map(int, size.split("x"))
    for i in range(repeat):
        render(program, scene, "-o", frame, "--driver", "bucket", "--aov", "time", "--threads", 1,
               "--size", size, "--spp", spp, "--bucket-order", ORDERS[i % len(ORDERS)])
        subprocess.run([program, "heatmap", frame, "--of", "time", "-o", numbers, "--quiet"], check=True)
        values = one_channel(numbers, width, height)
        min_seconds = array.array("f", map(min, min_seconds, values)) if min_seconds else values
    return width, height, min_seconds


def hilbert_step(k, x, y):
    """Returns the place of (x, y) on a Hilbert curve, as renderer/drivers/bucket_schedule.cpp does."""
    step = 0
    for bit in reversed(range(k)):
        rx, ry = x >> bit & 1, y >> bit & 1
        step = 4 * step + (3 * rx ^ ry)
        if not ry:
            if rx:
                x, y = ~x, ~y
            x, y = y, x
    return step


def bucket_order(width, height, size):
    """Returns the row-major bucket numbers in Hilbert order, which is the program's default."""
    columns, rows = -(-width // size), -(-height // size)
    k = (max(columns, rows) - 1).bit_length()
    return sorted(range(columns * rows), key=lambda i: hilbert_step(k, i % columns, i // columns))


def bucket_seconds(width, height, seconds, size):
    """Returns the sum of seconds over each bucket, in Hilbert order."""
    columns = -(-width // size)
    sums = [0.0] * (columns * -(-height // size))
    for y in range(height):
        row = seconds[y * width : (y + 1) * width]
        for column in range(columns):
            sums[y // size * columns + column] += sum(row[column * size : (column + 1) * size])
    return [sums[i] for i in bucket_order(width, height, size)]


def imbalance(parts):
    return max(parts) * len(parts) / sum(parts)


def interleaved(items, count):
    return [items[k::count] for k in range(count)]


def blocks(items, count):
    return [items[k * len(items) // count : (k + 1) * len(items) // count] for k in range(count)]


def check_order(program, scene, folder):
    """Checks that the program's parts contain the expected buckets."""
    for width, height, size, count in ((200, 136, 16, 3), (100, 300, 32, 5)):
        expected = interleaved(bucket_order(width, height, size), count)
        for k in range(count):
            output = folder / "order.exr"
            render(program, scene, "-o", output, "--size", f"{width}x{height}", "--spp", 1,
                   "--bucket-size", size, "--threads", 1, "--part", f"{k + 1}/{count}")
            checkpoint = folder / f"order.exr.part-{k + 1}-of-{count}.checkpoint"
            found = [record.number for record in parsed_file(checkpoint.read_bytes())[1] if record.kind == TILE]
            if found != expected[k]:
                sys.exit(f"part {k + 1}/{count} of {width}x{height} has buckets {found}, not {expected[k]}")
    print("The parts of two small frames hold the expected buckets, in the expected order.\n")


def add_frame_options(parser, size, spp):
    a = parser.add_argument
    a("program", type=pathlib.Path)
    a("scenes", nargs="+", metavar="SCENE")
    a("--assets", type=pathlib.Path, metavar="DIR")
    a("--size", default=size, help="size of the frame whose pixels are timed")
    a("--spp", type=int, default=spp)
    a("--repeat", type=int, default=3)


def numbers(text):
    return [int(word) for word in text.split(",")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_frame_options(parser, "640x360", 8)
    parser.add_argument("--parts", type=numbers, default=[4, 16, 64], metavar="LIST")
    parser.add_argument("--bucket-size", type=numbers, default=[64, 32], metavar="LIST")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    scenes = [Scene(name, options.assets) for name in options.scenes]

    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if options.check:
            check_order(options.program, scenes[0], folder)
        ways = [f"{way}, {count}" for way in ("interleaved", "blocks", "rows") for count in options.parts]
        print(f"| scene | bucket size | buckets | {' | '.join(ways)} |\n| --- |{' ---: |' * (len(ways) + 2)}")
        for scene in scenes:
            width, height, seconds = pixel_seconds(options.program, scene, options.size, options.spp,
                                                   options.repeat, folder)
            rows = [sum(seconds[y * width : (y + 1) * width]) for y in range(height)]
            for size in options.bucket_size:
                buckets = bucket_seconds(width, height, seconds, size)
                figures = [imbalance([sum(part) for part in cut(items, count)])
                           for cut, items in ((interleaved, buckets), (blocks, buckets), (blocks, rows))
                           for count in options.parts]
                cells = [scene.name, str(size), str(len(buckets)), *(f"{figure:.2f}" for figure in figures)]
                print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
