#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Every source file says its licence in one of its first lines. `reuse lint` would not miss that line, because .reuse/dep5 speaks for all
files, pictures and data among them, and so for a file that came from elsewhere, too."""
import pathlib
import sys

SOURCES = {".c", ".cpp", ".h", ".py", ".sh", ".cmake"}
LINE = "SPDX-License-Identifier" ": Zlib"  # in two, lest reuse takes it for this file's own


def is_source(path):
    return path.suffix in SOURCES or path.name == "CMakeLists.txt"


def sources(root):
    for place in sorted(root.iterdir()):
        if place.is_file() and is_source(place):
            yield place
        elif place.is_dir() and not place.name.startswith((".", "build")) and place.name != "data":
            yield from sorted(file for file in place.rglob("*") if file.is_file() and is_source(file))


def says_its_licence(file):
    with open(file, encoding="utf-8") as lines:
        return any(LINE in line for line, _ in zip(lines, range(3)))


root = pathlib.Path(sys.argv[1])
checked = list(sources(root))
silent = [file for file in checked if not says_its_licence(file)]
for file in silent:
    print(f"{file.relative_to(root)}: the line {LINE} is missing")
print(f"{len(checked)} files, {len(silent)} without their licence")
sys.exit(1 if silent or not checked else 0)
