#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Has another compiler read every source that a build has in some folders, warnings as errors; writes no objects.
Usage: other_compiler_accepts.py [--compiler COMPILER] [--std STANDARD] SOURCE BUILD THIS_COMPILER_ID FOLDER...
BUILD: with compile_commands.json. COMPILER: without it the other of g++ and clang++. STANDARD: as in -std, without it the build's.
Exit status 77: the other compiler, or that file, is missing."""
import argparse
import concurrent.futures
import json
import os
import pathlib
import shlex
import shutil
import subprocess
import sys

SKIPPED = 77
# What each compiler has a way of its own for, or a package.
LEFT_OUT = ("-fopenmp", "-fsanitize", "-fschedule-insns", "-fsched-pressure", "-fpch-preprocess", "-Winvalid-pch")
# The last: clang 17 and later report a deprecated function that libstdc++ 12 itself calls in std::stable_sort.
ADDED = ["-fsyntax-only", "-Wno-unknown-pragmas", "-Wno-unknown-warning-option", "-Wno-deprecated-declarations"]


def options(entry):
    """The words between compiler and output in one line of compile_commands.json, without the precompiled header: each source includes
    what it uses."""
    words = shlex.split(entry["command"])
    if "-include" in words:
        at = words.index("-include")
        del words[at:at + 2]
    first = next(i for i, word in enumerate(words) if word.startswith("-"))
    return [word for word in words[first:words.index("-o")] if not word.startswith(LEFT_OUT)]


def chosen(entries, source, folders):
    """One entry for each file and choice of its code; Bullet's precision chooses too little to read all twice."""
    found = {}
    for entry in entries:
        file = pathlib.Path(entry["file"])
        if file.suffix != ".cpp" or not file.is_relative_to(source) or file.relative_to(source).parts[0] not in folders:
            continue
        choice = frozenset(word for word in options(entry) if word.startswith(("-D", "-m")) and word != "-DBT_USE_DOUBLE_PRECISION")
        found.setdefault((file, choice), entry)
    return found.values()


def main():
    parser = argparse.ArgumentParser()
    for option in ("--compiler", "--std"):
        parser.add_argument(option)
    for argument in ("source", "build", "this_compiler"):
        parser.add_argument(argument)
    parser.add_argument("folders", nargs="+")
    arguments = parser.parse_args()
    source, build, folders = arguments.source, arguments.build, arguments.folders
    compiler = arguments.compiler or ("clang++" if arguments.this_compiler == "GNU" else "g++")
    standard = [f"-std={arguments.std}"] if arguments.std else []
    if not shutil.which(compiler):
        print(f"skipped: no {compiler} (apt-get install {compiler.replace('clang++', 'clang')})")
        return SKIPPED
    commands = pathlib.Path(build, "compile_commands.json")
    if not commands.exists():
        print(f"skipped: no {commands}, which generators for Ninja and make write")
        return SKIPPED
    entries = chosen(json.loads(commands.read_text()), source, folders)

    def complaints(entry):
        line = [compiler, *options(entry), *ADDED, *standard, entry["file"]]
        run = subprocess.run(line, cwd=entry["directory"], capture_output=True, text=True)
        return run.stderr or (f"{entry['file']}: {compiler} ended with {run.returncode}" if run.returncode else "")

    with concurrent.futures.ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        found = [text for text in pool.map(complaints, entries) if text]
    print("\n".join(found))
    print(f"{compiler} read {len(entries)} sources, {len(found)} with complaints")
    return 1 if found or not entries else 0


if __name__ == "__main__":
    sys.exit(main())
