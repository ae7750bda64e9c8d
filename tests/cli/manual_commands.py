#!/usr/bin/env python3
"""Runs every `emberline` command in README.md and the manual with tiny frames. Each command must exit with 0.

    manual_commands.py EMBERLINE [--python PYTHON] [PAGE...]

A command is a line in a ```sh block that begins with `emberline`. With --python, lines that begin with `python3` are
also commands; PYTHON runs them, and PYTHONPATH must contain the module. The commands of each page run in order, in a
folder that contains only a link to scenes/. `> FILE` at the end of a command works as in a shell. A comment before a
block can change what happens to the block:

    <!-- not run: needs Slurm -->    skips the block, for this reason
    <!-- file: look.json -->         writes the block to this file
"""

import argparse
import concurrent.futures
import glob
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "renderer/app/manual").glob("*.md"))]
TIMEOUT = 60  # in seconds, for each command

# New values for options that determine how long a command takes, or that depend on the size of the frame.
SHORT_VALUES = {
    "--bucket-size": "8",
    "--crop": "0,0,16,9",
    "--explain": "16,9",
    "--frames": "1-2",
    "--noise-threshold": "0.5",
    "--replay": "16,9,0",
    "--seeds": "1",
    "--size": "32x18",
    "--spp": "1",
    "--time-budget": "0.1",
    "--turntable": "2",
}
# A command gets these options if the page does not give them.
DEFAULT_OPTIONS = {
    "render": ("--size", "--spp", "--bucket-size"),
    "plan": ("--size", "--spp", "--bucket-size"),
    "farm": ("--size", "--spp", "--bucket-size"),
    "study": ("--size", "--seeds"),
}


class Command:
    def __init__(self, line, words):
        self.line, self.words = line, words


class Page:
    """The commands on a page, and the files that they read."""

    def __init__(self, path):
        self.path, self.commands, self.files, self.faults, self.skipped = path, [], {}, [], 0
        comment, block, language, begin = "", None, "", 0
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if block is None and line.startswith("```"):
                block, language, begin = [], line[3:].strip(), number
            elif block is not None and line.startswith("```"):
                self.add_block(comment, language, begin, block)
                comment, block = "", None
            elif block is not None:
                block.append(line)
            elif line.startswith("<!--"):
                comment = line
            elif line.strip():
                comment = ""
                if line.startswith("    ") and line.split()[0] == "emberline":
                    self.faults.append(f"{number}: a command outside of a ```sh block, which is not run")

    def add_block(self, comment, language, begin, block):
        file = re.fullmatch(r"<!-- file: (\S+) -->", comment)
        if file:
            self.files[file[1]] = "\n".join(block) + "\n"
        if language != "sh":
            return
        skipped = re.fullmatch(r"<!-- not run: \w.* -->", comment)
        text, number = "", begin
        for line in block:
            number += 1
            text, first = (text + line, first) if text else (line, number)
            if text.endswith("\\"):
                text = text[:-1] + " "
                continue
            words = shlex.split(re.sub(r"(^|\s)#.*", "", text))
            text = ""
            if words and words[0] in ("emberline", "python3"):
                if skipped:
                    self.skipped += 1
                else:
                    self.commands.append(Command(first, words))


def shorten_command(words, folder):
    """Returns the words of the command with values that make it take a fraction of a second."""
    command = words[0] if words else ""
    words = [name for word in words for name in (sorted(glob.glob(word, root_dir=folder)) or [word])]
    denoised = {"--denoise", "denoising"} & {part for word in words for part in word.split(",")}
    values = dict(SHORT_VALUES)
    if command == "study":
        values["--spp"] = "1,2"
        if "--seconds" in words:
            words[words.index("--seconds")] = "--spp"
    if command == "extend":
        values["--spp"] = "2"
    if denoised or "--min-spp" in words or "variance" in " ".join(words):
        values["--spp"] = "16"  # --spp must be at least --min-spp, and a variance needs two samples
    if command == "explain":
        words = [re.sub(r"^\d+,\d+$", values["--explain"], word) for word in words]
    if "--panorama" in words:
        values["--size"] = "32x16"
    if "--turntable" in words:
        values["--frames"] = "2"
    result = []
    for number, word in enumerate(words):
        before = words[number - 1] if number else ""
        result.append(values.get(before, word))
    if "--sample-range" not in words:
        for option in DEFAULT_OPTIONS.get(command, ()):
            if option not in words and not (option == "--spp" and {"--time-budget", "--plan"} & set(words)):
                result += [option, values[option]]
    return result


def shorten_script(text):
    return re.sub(r"spp=\d+", "spp=16", re.sub(r"size=\(\d+, \d+\)", "size=(32, 18)", text))


def run(programs, page):
    """Runs the commands of a page. Returns the faults, each with its line. `programs` maps names to programs."""
    faults = list(page.faults)
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "scenes").symlink_to(ROOT / "scenes")
        for name, text in page.files.items():
            pathlib.Path(folder, name).write_text(shorten_script(text) if name.endswith(".py") else text)
        for command in page.commands:
            name, *words = command.words
            if not programs[name]:
                continue
            output = words[words.index(">") + 1] if ">" in words else None
            if output:
                del words[words.index(">"):]
            if name == "emberline":
                words = shorten_command(words, folder)
            try:
                done = subprocess.run([programs[name], *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
                                      text=True, timeout=TIMEOUT)
            except subprocess.TimeoutExpired:
                faults.append(f"{command.line}: not finished after {TIMEOUT} s: {shlex.join([name, *words])}")
                continue
            if output:
                pathlib.Path(folder, output).write_text(done.stdout)
            if done.returncode != 0:
                message = done.stderr.strip().splitlines()[-1:] or [""]
                faults.append(f"{command.line}: exit code {done.returncode} of {shlex.join([name, *words])}\n"
                              f"    {message[0][:300]}")
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("emberline", type=pathlib.Path)
    parser.add_argument("--python")
    parser.add_argument("pages", nargs="*", type=pathlib.Path, default=PAGES)
    arguments = parser.parse_intermixed_args()
    programs = {"emberline": arguments.emberline.resolve(), "python3": arguments.python}
    pages = [Page(path) for path in arguments.pages]
    failed = False
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for page, faults in zip(pages, pool.map(lambda page: run(programs, page), pages)):
            for fault in faults:
                print(f"{page.path}:{fault}")
                failed = True
    commands = sum(len(page.commands) for page in pages)
    print(f"{commands} commands of {len(pages)} pages, and {sum(page.skipped for page in pages)} that are not run")
    if commands == 0:
        sys.exit("no commands found")
    sys.exit(failed)


if __name__ == "__main__":
    main()
