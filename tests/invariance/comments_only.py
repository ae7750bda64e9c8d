#!/usr/bin/env python3
"""Checks that a commit or a range of commits changes only comments: with comments stripped, each file stays the same.

    comments_only.py COMMIT          COMMIT against its parent
    comments_only.py BASE..HEAD      HEAD against BASE

Strips comments from C++, Python (docstrings included), CMake, shell and YAML, and treats any white space as one blank.
Ignores Markdown. Names the other files that differ and exits with 1.
"""
import ast
import io
import re
import subprocess
import sys
import tokenize

CPP = re.compile(r'R"([^()\\ ]*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])*\'|//[^\n]*|/\*.*?\*/', re.S)
HASH = re.compile(r'"(?:\\.|[^"\\])*"|\'[^\']*\'|(?:(?<=\s)|^)#[^\n]*', re.M | re.S)


def git(*args):
    return subprocess.run(["git", *args], capture_output=True, check=True).stdout


def without_comments(text, pattern):
    kept = pattern.sub(lambda m: " " if m[0].startswith(("//", "/*", "#")) else m[0], text)
    return re.sub(r"\s+", " ", kept).strip()


def python_without_comments(text):
    docstrings = set()
    for node in ast.walk(ast.parse(text)):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            docstrings.add((body[0].lineno, body[0].col_offset))
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    layout = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE)
    return [(t.type, "" if t.type == tokenize.INDENT else t.string) for t in tokens
            if t.type not in layout and not (t.type == tokenize.STRING and t.start in docstrings)]


def stripped(path, content):
    text = content.decode("utf-8", "replace")
    if path.endswith((".cpp", ".h", ".in")):
        return without_comments(text, CPP)
    if path.endswith(".py"):
        return python_without_comments(text)
    if path.endswith((".sh", ".cmake", ".yml", "CMakeLists.txt")):
        return without_comments(text, HASH)
    return content


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    base, _, head = sys.argv[1].partition("..")
    if not head:
        base, head = sys.argv[1] + "^", sys.argv[1]
    status = git("diff", "--no-renames", "--name-status", base, head).decode().splitlines()
    differ = []
    for line in status:
        kind, path = line.split("\t")
        if path.endswith(".md"):
            continue
        if kind != "M" or stripped(path, git("show", f"{base}:{path}")) != stripped(path, git("show", f"{head}:{path}")):
            differ.append(path)
    for path in differ:
        print(f"{path}: more than comments has changed")
    sys.exit(1 if differ else 0)


main()
