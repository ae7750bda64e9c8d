"""Fails when a folder includes one that the design does not allow, or when a header includes something slow to
compile."""
import pathlib
import re
import sys

# Maps each folder to the folders directly below it. A folder may include these folders, and everything that they may
# include.
DEPENDENCIES = {
    "renderer/core": [],
    "renderer/description": ["renderer/core"],
    "renderer/film": ["renderer/core"],
    "renderer/reconstruction": ["renderer/core"],
    "samplers": ["renderer/core"],
    "renderer/shading": ["renderer/description"],
    "renderer/lights": ["renderer/description"],
    "renderer/scene": ["renderer/shading", "renderer/lights", "renderer/film", "samplers"],
    "integrators": ["renderer/scene"],
    "io": ["renderer/description", "renderer/film"],
    "renderer/drivers": ["integrators"],
    "renderer/engine": ["renderer/drivers", "renderer/reconstruction", "io"],
    "renderer/statistics": ["renderer/film", "samplers"],
    "renderer/output": ["renderer/engine", "renderer/statistics"],
    "renderer/statistics/study": ["renderer/output"],
    "renderer/session": ["renderer/output"],
    "renderer/window": ["renderer/session"],
    "renderer/api": ["renderer/statistics/study"],
    "renderer/api/python": ["renderer/api"],
    "renderer/app": ["renderer/statistics/study", "renderer/window"],
}


def allowed_folders(folder):
    return {folder}.union(*(allowed_folders(dependency) for dependency in DEPENDENCIES[folder]))


ALLOWED = {folder: allowed_folders(folder) for folder in DEPENDENCIES}

# Clients render through the engine. They may not include the folders that the engine renders with.
CLIENTS = ("renderer/api", "renderer/app", "renderer/session", "renderer/statistics/study", "renderer/window")
INTERNAL_FOLDERS = ("integrators/", "renderer/drivers/", "renderer/film/")

# Only renderer/scene/embree_api.h may include Embree.
EMBREE = re.compile(r"#include\s*<embree")
OWN_INCLUDE = re.compile(r'#include\s*"([^"]+)"')
# Only sources may include these libraries. Headers forward-declare the types (io/json/value.h holds a JSON value).
SOURCES_ONLY = re.compile(r"#include\s*[<\"](nlohmann/json\.hpp|(?:CLI|spdlog)/[^>\"]+)")
# Maps a header to the headers that it may not include, directly or indirectly.
FORBIDDEN_INCLUDES = {
    "renderer/engine/frame_settings.h": ["io/exr/writer.h", "renderer/film/filter.h", "renderer/scene/embree_isa.h"],
    "integrators/integrator.h": ["renderer/film/film.h", "renderer/scene/scene.h"],
    "renderer/drivers/frame_driver.h": ["renderer/film/film.h"],
}
GENERATED = "renderer/core/version.h"


def is_private_include(folder, included):
    """Returns True if the Python module includes one of our headers besides its own and the public C++ header."""
    ours = (folder + "/", "renderer/api/emberline.h")
    return folder == "renderer/api/python" and not included.startswith(ours)


def folder_of(path):
    return max((f for f in DEPENDENCIES if path.startswith(f + "/")), key=len, default=None)


def included_headers(root, header):
    """Returns all of our headers that `header` includes, directly or indirectly."""
    found, left = set(), [header]
    while left:
        for included in OWN_INCLUDE.findall((root / left.pop()).read_text(encoding="utf-8")):
            if included not in found and (root / included).exists():
                found.add(included)
                left.append(included)
    return found


def costly_headers(root):
    failures = []
    for folder in ("integrators", "io", "renderer", "samplers", "tests"):
        for header in sorted((root / folder).rglob("*.h")):
            for library in SOURCES_ONLY.findall(header.read_text(encoding="utf-8")):
                failures.append(f"{header.relative_to(root).as_posix()}: only sources may include <{library}>")
    for header, forbidden in FORBIDDEN_INCLUDES.items():
        for other in forbidden:
            if not (root / other).exists():
                failures.append(f"{other}: is barred from {header}, and is not in the tree")
        failures += [f"{header}: includes {other}, perhaps by way of another header"
                     for other in sorted(included_headers(root, header).intersection(forbidden))]
    return failures


def main(root):
    failures = costly_headers(root)
    checked = 0
    for source in sorted(root.rglob("*")):
        name = source.relative_to(root).as_posix()
        folder = folder_of(name)
        if folder is None or source.suffix not in (".h", ".cpp"):
            continue
        checked += 1
        text = source.read_text(encoding="utf-8")
        if EMBREE.search(text) and name != "renderer/scene/embree_api.h":
            failures.append(f"{name}: only renderer/scene/embree_api.h includes Embree")
        for included in OWN_INCLUDE.findall(text):
            target = folder_of(included)
            if not (root / included).exists() and included != GENERATED:
                if target is not None or "/" in included:
                    failures.append(f"{name}: includes {included}, which is not in the tree")
            elif target is not None and (target not in ALLOWED[folder] or is_private_include(folder, included)):
                failures.append(f"{name}: {folder} may not include {included}")
            elif folder.startswith(CLIENTS) and included.startswith(INTERNAL_FOLDERS):
                failures.append(f"{name}: a client of the engine does not include {included}")
    for folder in DEPENDENCIES:
        if not any((root / folder).rglob("*.h")):
            failures.append(f"{folder}: no headers; is it still there?")
    print("\n".join(failures) or f"{checked} files, every include goes the right way")
    return 1 if failures or checked == 0 else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
