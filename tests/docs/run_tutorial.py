#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Does what docs/tutorial.md says, in an empty folder: its CMakeLists.txt, each of its programs by its first ```sh block, the last of them by the other blocks, too.
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
if not programs or len(lists) != 1 or not commands:
    sys.exit("the page has no program, no command, or not one CMakeLists.txt")
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
