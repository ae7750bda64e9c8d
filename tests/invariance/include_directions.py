"""Fails when a folder includes one that the design does not let it see."""
import pathlib
import re
import sys

# Folder -> folders it may include from, itself left out. Files named alone are exceptions.
CORE = ["renderer/core"]
DESCRIPTION = ["renderer/scene/scene_description.h", "renderer/scene/scene_edits.h"]
ALLOWED = {
    "renderer/core": [],
    "samplers": CORE,
    "renderer/film": CORE,
    "renderer/shading": CORE + DESCRIPTION,
    "renderer/lights": CORE + DESCRIPTION,
    "io": CORE + ["renderer/film"] + DESCRIPTION,
}
ALLOWED["renderer/scene"] = CORE + ["renderer/shading", "renderer/lights", "renderer/film"]
ALLOWED["integrators"] = ALLOWED["renderer/scene"] + ["renderer/scene", "samplers"]
ALLOWED["renderer/drivers"] = ALLOWED["integrators"] + ["integrators"]
ALLOWED["renderer/statistics"] = ALLOWED["integrators"] + ["integrators"]
ALLOWED["renderer/app"] = ALLOWED["renderer/drivers"] + ["renderer/drivers", "renderer/statistics", "io"]

# Embree is named in one header; only the folder's own sources may include it.
EMBREE = re.compile(r"#include\s*<embree")
OURS = re.compile(r'#include\s*"([^"]+)"')


def folder_of(path, folders):
    return max((f for f in folders if path.startswith(f + "/")), key=len, default=None)


def main(root):
    failures = []
    checked = 0
    for source in sorted(root.rglob("*")):
        name = source.relative_to(root).as_posix()
        folder = folder_of(name, ALLOWED)
        if folder is None or source.suffix not in (".h", ".cpp"):
            continue
        checked += 1
        text = source.read_text(encoding="utf-8")
        if EMBREE.search(text) and name != "renderer/scene/embree_api.h":
            failures.append(f"{name}: only renderer/scene/embree_api.h includes Embree")
        for included in OURS.findall(text):
            target = folder_of(included, ALLOWED)
            if target is None:
                if not (root / included).exists() and included != "renderer/app/version.h":
                    failures.append(f"{name}: includes {included}, which is not in the tree")
            elif target != folder and target not in ALLOWED[folder] and included not in ALLOWED[folder]:
                failures.append(f"{name}: {folder} may not include {included}")
    print("\n".join(failures) or f"{checked} files, every include goes the right way")
    return 1 if failures or checked == 0 else 0


sys.exit(main(pathlib.Path(sys.argv[1])))
