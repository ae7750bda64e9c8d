"""Checks that every test in README.md's table of promises exists.

promises.py TESTS     TESTS: the folder of all tests
"""
import pathlib
import re
import sys


def main():
    tests = pathlib.Path(sys.argv[1])
    existing_tests = {match.groups() for source in tests.rglob("*.cpp")
             for match in re.finditer(r"\bTEST(?:_[FP])?\(\s*(\w+),\s*(\w+)\)", source.read_text())}
    for source in tests.rglob("*_test.py"):
        suite = ""
        for class_name, test in re.findall(r"^class (\w+)|^    def (test_\w+)", source.read_text(), re.M):
            suite = class_name or suite
            existing_tests.add((suite, test))
    for source in (tests / "blender").glob("in_*.py"):  # cases of addon_test.py
        existing_tests |= {("blender", case) for case in re.findall(r"^def (\w+)\(\):", source.read_text(), re.M)}
    text = (tests / "failure" / "README.md").read_text()
    rows = [line for line in text[text.index("## Promises"):].splitlines() if line.startswith("| ")][2:]
    missing = []
    for row in rows:
        suite = ""
        # The names are written as `Suite.Test`, `AnotherOfThatSuite` or `Suite.*`.
        names = re.findall(r"`([^`]+)`", row.rstrip("| ").split("|")[-1])
        for name in names:
            suite, test = name.split(".") if "." in name else (suite, name)
            if not any(s == suite and test in ("*", t) for s, t in existing_tests):
                missing.append(f"{suite}.{test}")
        if not names:
            missing.append(f"a test in the row {row}")
    for name in missing:
        print(f"README.md names {name}, which is not there", file=sys.stderr)
    return 1 if missing or len(rows) < 20 else 0


sys.exit(main())
