"""Draws the dependency graph of the libraries, as CMake links them, for Mermaid.

    python3 ci/target_graph.py build/release            prints it
    python3 ci/target_graph.py build/release --write    puts it into renderer/README.md
    python3 ci/target_graph.py build/release --check    fails if that file has another graph, or if there is a
                                                        cycle or a link that the design forbids
"""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
README = ROOT / "renderer/README.md"
BEGIN, END = "```mermaid\n", "```\n"
sys.path.insert(0, str(ROOT / "tests/invariance"))
from include_directions import ALLOWED  # noqa: E402


def read_links(build):
    """Reads targets.txt in the folder `build`. Returns, for each folder, the folders whose libraries it links."""
    lines = [line.split() for line in (build / "targets.txt").read_text().splitlines()]
    folders = {target: folder for folder, target, *_ in lines}
    linked = {folder: set() for folder, *_ in lines}
    for folder, _, *links in lines:  # a folder may have two libraries, as the window's folder does
        linked[folder] |= {folders[link] for link in links if link in folders} - {folder}
    return linked


def all_dependencies(links, folder, path=()):
    """Returns all direct and indirect dependencies of a folder's library."""
    if folder in path:
        sys.exit("libraries link to each other in a cycle: " + " -> ".join((*path, folder)))
    linked = links[folder]
    return linked.union(*(all_dependencies(links, b, (*path, folder)) for b in linked))


def draw(links):
    """Returns the graph with an arrow for each link, except for links that a longer path implies."""
    reachable = {folder: all_dependencies(links, folder) for folder in links}
    lines = ["graph BT"]
    for folder in links:
        for linked in sorted(links[folder]):
            if not any(linked in reachable[other] for other in links[folder]):
                lines.append("  {} --> {}".format(*(f.removeprefix("renderer/")
                                                    for f in (folder, linked))))
    return "\n".join(lines) + "\n"


def main(build, action=""):
    links = read_links(pathlib.Path(build))
    graph = draw(links)
    if not action:
        print(graph, end="")
        return
    text = README.read_text()
    begin = text.index(BEGIN) + len(BEGIN)
    end = text.index(END, begin)
    if action == "--write":
        README.write_text(text[:begin] + graph + text[end:])
        return
    for folder in links:
        for linked in all_dependencies(links, folder) - ALLOWED[folder]:
            sys.exit(f"{folder} must not depend on {linked}")
    if text[begin:end] != graph:
        sys.exit(f"the graph in {README.relative_to(ROOT)} differs from CMake's; update it with --write")


if __name__ == "__main__":
    main(*sys.argv[1:])
