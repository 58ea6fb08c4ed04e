#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Does what docs/tutorial.md says, in an empty folder: its CMakeLists.txt, each of its programs by its first ```sh block, the last of them by the other blocks, too;
and its assets, of two boxes.
Usage: run_tutorial.py PAGE PREFIX FOLDER, PREFIX being where the library is installed, which the page calls ~/bullethaptics"""
import os
import pathlib
import re
import subprocess
import sys

page, prefix, folder = pathlib.Path(sys.argv[1]).read_text(), sys.argv[2], pathlib.Path(sys.argv[3])


def blocks(kind):
    return [match.group(1) for match in re.finditer(rf"^```{kind}\n(.*?)^```", page, re.M | re.S)]


programs, lists, commands = blocks("cpp file"), blocks("cmake"), blocks("sh")
if not programs or len(lists) != 2 or not commands:
    sys.exit("the page has no program, no command, or not one CMakeLists.txt and one for assets")
loader = {**os.environ, "LD_LIBRARY_PATH": f"{prefix}/lib"}  # where the build made shared libraries, which pkg-config's flags alone do not find
for number, program in enumerate(programs):
    for command in commands if number + 1 == len(programs) else commands[:1]:
        place = folder / f"{number}-{commands.index(command)}"
        place.mkdir(parents=True)
        (place / "CMakeLists.txt").write_text(lists[0])
        (place / "first.cpp").write_text(program)
        done = subprocess.run(["bash", "-ec", command.replace("~/bullethaptics", prefix)], cwd=place, text=True, capture_output=True, env=loader)
        last = (done.stdout.strip().splitlines() or [""])[-1]
        if done.returncode or not last:
            sys.exit(f"{command}{done.stdout}{done.stderr}")
        print(last)

CORNERS = [(x, y, z) for x in (0, 2) for y in (0, 1) for z in (0, 1)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = [(s[0], s[i], s[i + 1]) for s in SIDES for i in (1, 2)]
place = folder / "assets"
place.mkdir()
(place / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\nproject(assets LANGUAGES CXX)\n" + lists[1])
(place / "bunny.obj").write_text("".join("v %g %g %g\n" % c for c in CORNERS) + "".join("f %d %d %d\n" % tuple(i + 1 for i in t) for t in TRIANGLES))
facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % CORNERS[i] for i in t) + "endloop\nendfacet\n" for t in TRIANGLES)
(place / "stairs.stl").write_text(f"solid stairs\n{facets}endsolid stairs\n")
done = subprocess.run(["bash", "-ec", f"cmake -B build -DCMAKE_PREFIX_PATH={prefix} && cmake --build build"], cwd=place, text=True, capture_output=True, env=loader)
made = sorted(path.name for path in (place / "build").glob("*.ist"))
if done.returncode or made != ["bunny.ist", "stairs.ist"]:
    sys.exit(f"{made}{done.stdout}{done.stderr}")
print("assets:", *made)
