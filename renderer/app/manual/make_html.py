#!/usr/bin/env python3
"""Builds the manual as HTML files that can be read without a network: make_html.py MKDOCS GENERATED OUT

MKDOCS is the program mkdocs. GENERATED is the folder in which the command has written options.md and channels.md. OUT
is the folder to be replaced. Pictures in scenes/gallery are copied, because a site cannot use files outside its folder.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
GALLERY = HERE.parents[2] / "scenes" / "gallery"
GENERATED = {"options.md": "`emberline render --help` lists the options.",
             "channels.md": "`emberline info --channels` lists the channels."}


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    mkdocs, generated, out = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        site = pathlib.Path(folder)
        pages = site / "docs"
        shutil.copytree(HERE / "pictures", pages / "pictures")
        (pages / "gallery").mkdir()
        for page in HERE.glob("*.md"):
            text, _ = re.subn(r"\]\(\.\./\.\./\.\./scenes/gallery/", "](gallery/", page.read_text())
            for picture in re.findall(r"\]\(gallery/([^)]+)\)", text):
                shutil.copy(GALLERY / picture, pages / "gallery")
            (pages / page.name).write_text(text)
        for name, otherwise in GENERATED.items():
            if (generated / name).exists():
                shutil.copy(generated / name, pages)
            else:
                (pages / name).write_text(f"# {name[:-3].capitalize()}\n\n{otherwise}\n")
        shutil.copy(HERE / "mkdocs.yml", site)
        subprocess.run([mkdocs, "build", "--quiet", "--strict", "--clean", "--site-dir", out], cwd=site, check=True)
    for name in ("404.html", "sitemap.xml", "sitemap.xml.gz"):  # useless without a server
        (out / name).unlink(missing_ok=True)
    print(f"manual: {out / 'index.html'}")


if __name__ == "__main__":
    try:
        main()
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"make_html.py: {error}")
