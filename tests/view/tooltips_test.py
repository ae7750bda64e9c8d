#!/usr/bin/env python3
"""Tests that every control of the window has a tooltip.

    tests/view/tooltips_test.py renderer/window

The functions of panels/widgets.h and panels/action_widgets.h draw controls, and require a tooltip that is not empty.
The test checks that other files do not call the functions with which ImGui draws controls.
"""
import pathlib
import re
import sys

CONTROLS = re.compile(
    r"ImGui::(\w*Button|Checkbox\w*|MenuItem|\w*Slider\w*|Drag\w+|Input\w+|Color(?:Edit|Picker)\w*|BeginCombo|Combo|ListBox)\(")
WITH_TOOLTIPS = {"widgets.cpp", "action_widgets.cpp"}


def bare_controls(folder):
    for path in sorted(folder.rglob("*.cpp")):
        if path.name in WITH_TOOLTIPS:
            continue
        lines = path.read_text().splitlines()
        for number, line in enumerate(lines):
            control = CONTROLS.search(line)
            if control and "help(" not in "".join(lines[number:number + 2]):
                yield f"{path}:{number + 1}: ImGui::{control[1]} has no tooltip; use panels/widgets.h"


def main():
    folder = pathlib.Path(sys.argv[1])
    faults = list(bare_controls(folder))
    # In a wrong folder, the test would find nothing and pass.
    if not WITH_TOOLTIPS <= {path.name for path in folder.rglob("*.cpp")}:
        faults.append(f"{folder}: panels/widgets.cpp was not found")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
