#!/usr/bin/env python3
"""Writes Emberline's own scenes and environment maps (see README.md beside this file).

    make_scenes.py [--out DIR] [NAME ...]    write the files (default: beside this script)
    make_scenes.py --check [NAME ...]        compare with the files beside this script; exit with 1 if any file differs

The script needs only the standard library. It writes the same bytes on every machine: it uses no clock, no hash order
and no zlib, and it rounds coordinates to a grid.
"""

import argparse
import pathlib
import sys

sys.dont_write_bytecode = True  # keeps the source tree clean when a test runs this

from make import (caustics, checker_plane, cornell_box, environments, glass_metal, material_rows, mis_plates, moving_blade,
                  night_street, roughness_spheres, shallow_focus, spheres, teapot, thin_wires, window_room)

HERE = pathlib.Path(__file__).resolve().parent

FILES = {
    "teapot.glb": teapot.build,
    "spheres.glb": spheres.build,
    "cornell_box.glb": cornell_box.build,
    "roughness_spheres.glb": roughness_spheres.build,
    "mis_plates.glb": mis_plates.build,
    "checker_plane.glb": checker_plane.build,
    "thin_wires.glb": thin_wires.build,
    "glass_metal.glb": glass_metal.build,
    "material_rows.glb": material_rows.build,
    "moving_blade.glb": moving_blade.build,
    "shallow_focus.glb": shallow_focus.build,
    "night_street.glb": night_street.build,
    "window_room.glb": window_room.build,
    "caustics.glb": caustics.build,
    "studio.hdr": environments.studio,
    "dusk.hdr": environments.dusk,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="names of files or scenes (default: all)")
    parser.add_argument("--out", type=pathlib.Path, default=HERE)
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()

    unknown = [n for n in options.names if n not in FILES and f"{n}.glb" not in FILES and f"{n}.hdr" not in FILES]
    if unknown:
        parser.error(f"unknown names: {', '.join(unknown)}; valid names are: {', '.join(FILES)}")
    selected = [f for f in FILES if not options.names or f in options.names or f.rsplit(".", 1)[0] in options.names]

    different = 0
    for file in selected:
        data = FILES[file]()
        if options.check:
            committed = HERE / file
            same = committed.is_file() and committed.read_bytes() == data
            different += not same
            print(f"{file}: {'same' if same else 'DIFFERENT'} ({len(data)} bytes)", flush=True)
        else:
            options.out.mkdir(parents=True, exist_ok=True)
            (options.out / file).write_bytes(data)
            print(f"{options.out / file}: {len(data)} bytes", flush=True)
    if different:
        print(f"{different} of {len(selected)} files differ from what make_scenes.py writes", file=sys.stderr)
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
