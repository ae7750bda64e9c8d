"""Reads `llvm-cov export -summary-only` and prints the share of covered lines and branches for each folder of the
source tree and each file of io/.

usage: llvm-cov export ... | coverage_by_folder.py SOURCE_TREE SOURCES_OF_LIBRARIES
"""

import json
import os
import sys


def group_of(name, tree, libraries):
    if name.startswith(libraries + "/"):
        return os.path.relpath(name, libraries).split("/")[0]
    path = os.path.relpath(name, tree)
    if path.startswith(("tests/", "..")):
        return None
    return path if path.startswith("io/") else os.path.dirname(path)


def main():
    tree, libraries = (os.path.realpath(path) for path in sys.argv[1:3])
    sums = {}
    for entry in json.load(sys.stdin)["data"][0]["files"]:
        group = group_of(os.path.realpath(entry["filename"]), tree, libraries)
        names = [group] if group else []
        if group and group.startswith("io/"):
            names = [os.path.splitext(group)[0], "io"]
        for name in names:
            row = sums.setdefault(name, [0, 0, 0, 0])
            for i, kind in enumerate(("lines", "branches")):
                row[2 * i] += entry["summary"][kind]["covered"]
                row[2 * i + 1] += entry["summary"][kind]["count"]
    print("| folder or part | lines | branches |\n| --- | ---: | ---: |")
    for name, (lines, all_lines, branches, all_branches) in sorted(sums.items()):
        share = f"{100 * branches / all_branches:.0f} %" if all_branches else ""
        print(f"| {name} | {100 * lines / max(all_lines, 1):.0f} % of {all_lines} | {share} |")


main()
