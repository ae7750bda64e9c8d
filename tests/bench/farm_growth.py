#!/usr/bin/env python3
"""Computes the time of a frame of 1920x1080 at 1024 samples on 1 to 1,000 nodes, from measured constants.

    tests/bench/farm_growth.py build/release/bin/emberline scenes/teapot.glb
        [--assets DIR SCENE...] [--cores 32] [--network 100] [--parts-per-node 4] [--bucket-size 16]
        [--plot scenes/gallery/farm_growth.svg]

Measures on two threads: the processor seconds per sample; the processor seconds of a process from its start to
its first sample (loading and building); the seconds of each pixel, for the balance; the size of the checkpoints
of 16 parts; and the processor seconds of `emberline merge` for these checkpoints.

Then it simulates a farm. All nodes start at once, and each takes the next part when it has finished one. A part
is a process: it reads the scene, loads, builds, and renders its buckets, each on one of the node's cores.
All nodes share a disk of --network MB/s. A node reads the scene for each part, or only once with staging (a copy
on the node), and does nothing else meanwhile. The nodes write checkpoints to the shared disk, and `merge` reads
them. `merge` is assumed to run on one core.
"""
import argparse
import dataclasses
import heapq
import json
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
from growth_plot import plot  # noqa: E402
from part_balance import Scene, add_frame_options, bucket_seconds, interleaved, numbers, pixel_seconds, render  # noqa: E402

NODES = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000)
WIDTH, HEIGHT, SAMPLES = 1920, 1080, 1024
PIXELS = WIDTH * HEIGHT


def processor_seconds(*command):
    """Runs the command and returns its user and system time."""
    process = subprocess.Popen([str(word) for word in command])
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{command[1]} failed")
    return usage.ru_utime + usage.ru_stime


@dataclasses.dataclass
class Constants:
    name: str
    scene_bytes: int
    ready_s: float  # start, load and build, per process
    render_s: float  # of the whole frame on one core
    pixels: tuple  # width, height, seconds of each pixel
    checkpoint_bytes: float  # of all parts
    merge_s: float

    def buckets(self, size):
        """Returns the single-core seconds of each bucket of the frame, in schedule order."""
        width, height, seconds = self.pixels
        sums = bucket_seconds(width, height, seconds, size)
        scale = self.render_s / sum(sums)
        return [scale * s for s in sums]


def measured(options, scene, folder):
    program, report = options.program, folder / "report.json"
    ready, per_sample = [], []
    for _ in range(5):
        render(program, scene, "-o", folder / "small.exr", "--size", "320x180", "--spp", 16, "--threads", 2,
               "--bucket-size", options.bucket_size, "--report", report)
        found = json.loads(report.read_text())
        ready.append(found["time"]["first_sample_cpu_s"])
        per_sample.append(found["time"]["render_cpu_s"] / found["samples"]["total"])

    def merge_of(size, bucket):
        """Returns the pixels, the bytes of 16 parts, and the processor seconds of merging them."""
        for k in range(1, 17):
            render(program, scene, "-o", folder / f"{size}.exr", "--size", size, "--spp", 1, "--threads", 2,
                   "--bucket-size", bucket, "--part", f"{k}/16")
        parts = sorted(folder.glob("*.checkpoint"))
        seconds = min(processor_seconds(program, "merge", "-o", folder / "merged.exr", "--quiet", *parts)
                      for _ in range(5))
        written = sum(part.stat().st_size for part in parts)
        for part in parts:
            part.unlink()
        width, height = map(int, size.split("x"))
        return width * height, written, seconds

    # Both frames have the same number of buckets, so that the cost per pixel excludes the cost per part and bucket.
    few, few_bytes, few_s = merge_of("160x90", 16)
    many, many_bytes, many_s = merge_of("1280x720", 128)
    per_pixel = (many_s - few_s) / (many - few)
    return Constants(scene.name, scene.bytes, min(ready), min(per_sample) * PIXELS * SAMPLES,
                     pixel_seconds(program, scene, options.size, options.spp, options.repeat, folder),
                     (many_bytes - few_bytes) / (many - few) * PIXELS, few_s + per_pixel * (PIXELS - few))


def makespan(seconds, workers):
    """Returns the time until the last job is done, if each worker takes the next job when it has finished one."""
    free = [0.0] * workers
    for s in seconds:
        heapq.heapreplace(free, free[0] + s)
    return max(free)


@dataclasses.dataclass
class Frame:
    """Seconds of one frame: reading, loading, rendering with all cores busy, waiting, merging."""
    read: float
    ready: float
    render: float
    wait: float  # for the slowest core and node
    merge: float

    @property
    def total(self):
        return self.read + self.ready + self.render + self.wait + self.merge

    @property
    def overhead(self):
        """The share of time other than rendering and waiting."""
        return (self.read + self.ready + self.merge) / self.total


def frame_over(c, buckets, nodes, parts_per_node, cores, disk, staged):
    rounds = parts_per_node
    parts = interleaved(buckets, nodes * parts_per_node)
    render_s = makespan([c.ready_s + makespan(part, cores) for part in parts], nodes) - rounds * c.ready_s
    even = c.render_s / (nodes * cores)
    return Frame(read=(1 if staged else rounds) * nodes * c.scene_bytes / disk, ready=rounds * c.ready_s,
                 render=even, wait=render_s - even, merge=c.merge_s + 2 * c.checkpoint_bytes / disk)


def duration(s):
    return f"{s:,.0f}" if s >= 100 else f"{s:.1f}" if s >= 10 else f"{s:.2f}"


def table(c, options, disk):
    buckets = c.buckets(options.bucket_size)

    def frame(nodes, parts=options.parts_per_node, staged=True):
        return frame_over(c, buckets, nodes, parts, options.cores, disk, staged)

    alone = frame(1, 1).total
    per_node = options.parts_per_node
    print(f"\n`{c.name}`: {c.scene_bytes / 1e6:.1f} MB to read, {c.ready_s:.2f} s from start to first sample, "
          f"{c.render_s:,.0f} s of rendering on one core, {c.checkpoint_bytes / 1e6:.0f} MB of checkpoints, "
          f"{c.merge_s:.2f} s of merging.\n\n"
          f"| nodes | {per_node} parts a node, staged: s | efficiency | read | load, build | render | wait | merge | "
          f"not staged: s | one part a node: s |\n| ---: |{' ---: |' * 9}")
    for nodes in NODES:
        f, raw, one = frame(nodes), frame(nodes, staged=False), frame(nodes, 1)
        shares = [f"{100 * s / f.total:.0f} %" for s in (f.read, f.ready, f.render, f.wait, f.merge)]
        cells = [f"{nodes:,}", duration(f.total), f"{100 * alone / (nodes * f.total):.0f} %", *shares,
                 duration(raw.total), duration(one.total)]
        print(f"| {' | '.join(cells)} |")


def bucket_sizes(all_constants, options, disk):
    """Prints the seconds by bucket size, with one part per node."""
    sizes, some = (64, 32, 16, 8), (16, 64, 256, 1000)
    print(f"\n| one part a node, s | buckets | {' | '.join(f'{n:,} nodes' for n in some)} |\n| --- |{' ---: |' * 5}")
    for c in all_constants:
        for size in sizes:
            buckets = c.buckets(size)
            cells = [duration(frame_over(c, buckets, n, 1, options.cores, disk, True).total) for n in some]
            print(f"| {c.name}, {size} | {len(buckets):,} | {' | '.join(cells)} |")


def curves(c, options, disk):
    """Yields the curves for the plot: name, whether staged, points (nodes, seconds), and the first point with more
    overhead than work."""
    buckets = c.buckets(options.bucket_size)
    fine = sorted({*NODES, *(round(10 ** (i / 12)) for i in range(37))})
    for staged, way in ((True, "staged"), (False, "not staged")):
        frames = [(n, frame_over(c, buckets, n, options.parts_per_node, options.cores, disk, staged)) for n in fine]
        half = next(((n, f.total) for n, f in frames if f.overhead > 0.5), None)
        yield f"{c.name}, {way}", staged, [(n, f.total) for n, f in frames], half


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_frame_options(parser, f"{WIDTH}x{HEIGHT}", 4)
    a = parser.add_argument
    a("--cores", type=int, default=32, help="cores of each node")
    a("--network", type=float, default=100, metavar="MB/S", help="total throughput of the shared disk")
    a("--parts-per-node", type=int, default=4)
    a("--bucket-size", type=int, default=16, help="bucket size of the 1920x1080 frame")
    a("--plot", type=pathlib.Path, metavar="FILE.svg")
    options = parser.parse_args()
    if options.size != f"{WIDTH}x{HEIGHT}":
        parser.error(f"--size: only {WIDTH}x{HEIGHT} is supported")

    with tempfile.TemporaryDirectory() as folder:
        found = [measured(options, Scene(name, options.assets), pathlib.Path(folder)) for name in options.scenes]
    disk = options.network * 1e6
    print(f"{WIDTH}x{HEIGHT}, {SAMPLES} samples, nodes of {options.cores} cores, {options.network:g} MB/s of shared disk, "
          f"buckets of {options.bucket_size}x{options.bucket_size}.")
    for c in found:
        table(c, options, disk)
    bucket_sizes(found, options, disk)
    for c in found:
        for name, _, _, half in curves(c, options, disk):
            print(f"\n{name}: reading, loading and merging take more than half of the time "
                  f"{f'from {half[0]:,} nodes on' if half else 'with no number of nodes'}.")
    if options.plot:
        subtitle = (f"{WIDTH}x{HEIGHT}, {SAMPLES:,} samples; nodes of {options.cores} cores, {options.parts_per_node} parts each; "
                    f"one shared disk of {options.network:g} MB/s")
        options.plot.write_text(plot("A frame over many nodes", subtitle,
                                     [curve for c in found for curve in curves(c, options, disk)]))


if __name__ == "__main__":
    main()
