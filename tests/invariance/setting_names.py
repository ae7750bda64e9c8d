"""Fails when a string literal outside renderer/app contains "--" and the name of a setting or of another option. How
an option is written depends on the client, so messages get the written form from setting_names.h. The examples in the
settings' help are commands, and may contain options.

  setting_names.py SOURCE PROGRAM"""

import pathlib
import re
import subprocess
import sys

source, program = pathlib.Path(sys.argv[1]), sys.argv[2]
FOLDERS = ("renderer", "integrators", "samplers", "io")
COMMAND = source / "renderer/app"

LITERAL_OR_COMMENT = re.compile(r'"(?:[^"\\\n]|\\.)*"|//[^\n]*|/\*.*?\*/', re.S)
OPTION = re.compile(r"--([a-z][a-z0-9-]+)")
EXAMPLE = re.compile(r"\.example =\s*\Z")  # before a literal
COMPOSED = re.compile(r'"--(?:"|\{)')  # "--" + name, "--{}"


def help_of(*command):
    return subprocess.run([program, *command, "--help-all"], capture_output=True, text=True, check=True).stdout


def options():
    commands = re.findall(r"^  ([a-z]+) ", help_of(), re.M)
    if not {"render", "view", "study"} <= set(commands):
        sys.exit(f"{program} --help-all lists no commands")
    return {name for command in commands for name in OPTION.findall(help_of(command))}


def main():
    names = options()
    if "noise-threshold" not in names or "env" not in names:
        sys.exit("the help texts list no options")
    found = seen = 0
    for folder in FOLDERS:
        for file in sorted((source / folder).rglob("*")):
            if file.suffix not in (".cpp", ".h") or COMMAND in file.parents:
                continue
            text = file.read_text()
            for match in LITERAL_OR_COMMENT.finditer(text):
                if match[0].startswith("/") or EXAMPLE.search(text, 0, match.start()):
                    continue
                seen += 1
                wrong = set(OPTION.findall(match[0])) & names
                if COMPOSED.match(match[0]):
                    wrong.add("...")
                for name in wrong:
                    found += 1
                    line = text.count("\n", 0, match.start()) + 1
                    print(f'{file.relative_to(source)}:{line}: "--{name}" should be "`{name}`"')
    if seen < 1000:
        sys.exit(f"found {seen} string literals in {source}, which cannot be")
    return found > 0


sys.exit(main())
