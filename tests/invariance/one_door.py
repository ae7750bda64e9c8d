"""Fails when code other than io/files/input_file.cpp (read) or io/files/atomic_file.cpp (write) opens a file. This way
their checks apply to every file."""
import pathlib
import re
import sys

FILE_OPENERS = {"io/files/input_file.cpp", "io/files/atomic_file.cpp"}
# Matches calls that open a file by name: those of C++ streams, of C, of the system, and of the libraries that we use.
OPEN_CALL = re.compile(
    r"\b(?:std::)?[io]?fstream\b"
    r"|\b(?:f|fd|fre|p)open(?:64)?\s*\("
    r"|(?<![\w>])::(?:open|openat|creat|mkstemp)(?:64)?\s*\("
    r"|ImageInput::open|ImageOutput::open|ImageBuf\b|ImageCache\b|TextureSystem\b"
    r"|(?:Input|Output)File\s*\([^)]*\.c_str\(\)"
    r"|AddFontFromFileTTF\b|CreateFromFile\b|SaveIniSettingsToDisk\b"
    r"|\bstbi?_(?:load|write)|LoadASCIIFromFile\b|LoadBinaryFromFile\b"
)
# Exceptions, each with its reason.
ALLOWED = {
    # An OpenColorIO config names further files (LUTs), which only OpenColorIO can find. InputFile checks
    # the config itself first.
    "io/display/display.cpp": ["CreateFromFile"],
    # tinygltf's header needs fstream. Nothing calls its functions on files.
    "io/gltf/document/tiny_gltf_build.cpp": ["fstream"],
    # Opens /dev/null in place of closed standard streams, before any other file.
    "renderer/app/standard_output.cpp": ["::open("],
}
COMMENT = re.compile(r"//.*$")


def main(root):
    failures = []
    used = set()
    for folder in ("renderer", "integrators", "samplers", "io"):
        for source in sorted((root / folder).rglob("*")):
            name = source.relative_to(root).as_posix()
            if source.suffix not in (".h", ".cpp") or name in FILE_OPENERS:
                continue
            for number, line in enumerate(source.read_text().splitlines(), 1):
                found = OPEN_CALL.search(COMMENT.sub("", line))
                if not found:
                    continue
                if found.group(0) in ALLOWED.get(name, ()):
                    used.add((name, found.group(0)))
                    continue
                failures.append(f"{name}:{number}: {found.group(0)} opens a file; use io/files/input_file.h or "
                                "io/files/atomic_file.h")
    for name, words in ALLOWED.items():
        failures += [f"{name}: no longer has {w}; take it out of ALLOWED"
                     for w in words if (name, w) not in used]
    print("\n".join(failures) or "every file goes through one door")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
