#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Does what docs/tutorial.md says, in an empty folder, with the CMakeLists.txt of the page.

Each program of the page is built by the first ```sh block, and the last program by the other blocks, too.
The library as part of the build is configured only, because consumer_game_add_subdirectory builds one. The assets are of two boxes.
Further pages have a CMakeLists.txt and a program of their own, which are built and run, too.
Usage: run_tutorial.py TUTORIAL PREFIX FOLDER [PAGE...]
PREFIX is where the library is installed, which the pages call ~/bullethaptics."""
import os
import pathlib
import re
import subprocess
import sys

tutorial, prefix, folder, *pages = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3]), *map(pathlib.Path, sys.argv[4:])
# The flags of pkg-config do not find shared libraries when a program runs.
loader = {**os.environ, "LD_LIBRARY_PATH": f"{prefix}/lib"}
FIND = "find_package(BulletHaptics 0.3 REQUIRED)\n"
BUNNY = "/usr/share/glmark2/models/bunny.obj"


def blocks(page, kind):
    return [match.group(1) for match in re.finditer(rf"^```{kind}\n(.*?)^```", page.read_text(), re.M | re.S)]


def run(command, place):
    """What it prints; where it fails, so does this."""
    shell = ["bash", "-ec", command.replace("~/bullethaptics", prefix)]
    done = subprocess.run(shell, cwd=place, text=True, capture_output=True, env=loader)
    if done.returncode:
        sys.exit(f"{command}{done.stdout}{done.stderr}")
    return done.stdout


def last_line(text):
    lines = text.strip().splitlines()
    return lines[-1] if lines else sys.exit("nothing was printed")


programs, lists, commands = (blocks(tutorial, kind) for kind in ("cpp file", "cmake", "sh"))
if not programs or len(lists) != 3 or FIND not in lists[0] or not commands:
    sys.exit("the page has no program, no command, or not one CMakeLists.txt, what stands there for find_package, and assets")
for number, program in enumerate(programs):
    for command in commands if number + 1 == len(programs) else commands[:1]:
        place = folder / f"{number}-{commands.index(command)}"
        place.mkdir(parents=True)
        (place / "CMakeLists.txt").write_text(lists[0])
        (place / "first.cpp").write_text(program)
        print(last_line(run(command, place)))

place = folder / "part"
place.mkdir()
(place / "BulletHaptics").symlink_to(tutorial.resolve().parents[1])
(place / "CMakeLists.txt").write_text(lists[0].replace(FIND, lists[1]))
(place / "first.cpp").write_text(programs[-1])
print(last_line(run("cmake -B build -DCMAKE_BUILD_TYPE=Release", place)))

CORNERS = [(x, y, z) for x in (0, 2) for y in (0, 1) for z in (0, 1)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = [(s[0], s[i], s[i + 1]) for s in SIDES for i in (1, 2)]
place = folder / "assets"
place.mkdir()
(place / "CMakeLists.txt").write_text(lists[0].partition(FIND)[0] + FIND + lists[2])
vertices = "".join("v %g %g %g\n" % c for c in CORNERS)
(place / "bunny.obj").write_text(vertices + "".join("f %d %d %d\n" % tuple(i + 1 for i in t) for t in TRIANGLES))
facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex %g %g %g\n" % CORNERS[i] for i in t) + "endloop\nendfacet\n"
                 for t in TRIANGLES)
(place / "stairs.stl").write_text(f"solid stairs\n{facets}endsolid stairs\n")
told = run("cmake -B build -DCMAKE_PREFIX_PATH=~/bullethaptics && cmake --build build", place)
made = sorted(path.name for path in (place / "build").glob("*.ist"))
if made != ["bunny.ist", "stairs.ist"]:
    sys.exit(f"{made}{told}")
print("assets:", *made)

for page in pages:
    place = folder / page.stem
    place.mkdir()
    (place / "CMakeLists.txt").write_text(*blocks(page, "cmake"))
    name = re.search(r"add_executable\((\w+)", blocks(page, "cmake")[0]).group(1)
    program = next(text for text in blocks(page, "cpp file") if BUNNY not in text or pathlib.Path(BUNNY).exists())
    (place / f"{name}.cpp").write_text(program)
    print(last_line(run(commands[0].replace("build/first", f"build/{name}"), place)))
