#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Has another compiler read every source that a build has in some folders, warnings as errors; writes no objects.
Usage: other_compiler_accepts.py [--compiler COMPILER] [--std STANDARD] [--windows] SOURCE BUILD THIS_COMPILER_ID FOLDER...
BUILD: with compile_commands.json. COMPILER: without it the other of g++ and clang++. STANDARD: as in -std, without it the build's.
--windows: BUILD is one of the preset windows-mingw, which is configured there where it is missing, and clang++ looks for what Visual Studio
would stumble over. That is extensions of Microsoft's, 64-bit values in `long`, in installed headers words that only GCC and clang know, and
those headers behind <windows.h> with its macros `min`, `max`, `near`, `far`.
Exit status 77: the other compiler, that file, or what the preset needs, is missing."""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
# What each compiler has a way of its own for, or a package.
LEFT_OUT = ("-fopenmp", "-fsanitize", "-fschedule-insns", "-fsched-pressure", "-fpch-preprocess", "-Winvalid-pch", "-Wa,",
            "-fno-keep-inline-dllexport")
# The last: clang 17 and later report a deprecated function that libstdc++ 12 itself calls in std::stable_sort.
ADDED = ["-fsyntax-only", "-Wno-unknown-pragmas", "-Wno-unknown-warning-option", "-Wno-deprecated-declarations"]

# With --windows.
MINGW = "x86_64-w64-mingw32"
TRAPS = ["-fms-extensions", "-Wmicrosoft", "-Wno-error=microsoft", "-Wshorten-64-to-32", "-Wno-error=shorten-64-to-32"]
HEADER_TRAPS = ["-fms-extensions", "-Wmicrosoft", "-Wgnu", "-Wc++20-extensions"]
# `int` for a size is meant where it stands; `long` has 64 bits on Linux.
TRAP = re.compile(r"warning: .*(to '(unsigned )?long'|\[-Wmicrosoft)")
UNKNOWN_WORD = re.compile(r"__attribute__|__builtin_|__restrict__|__PRETTY_FUNCTION__|\bssize_t\b|\bM_PI\b|__asm__|\b__int128\b")
HAS_A_BRANCH = "DeviceBridge/Plugins/devicebridge_plugin.h"  # one for each compiler
# Macros of <windows.h> and its companions that its own NOMINMAX and WIN32_LEAN_AND_MEAN leave out.
MACROS = "".join(f"#undef {name}\n#define {name}{value}\n" for name, value in (
    ("min", "(a, b) (((a) < (b)) ? (a) : (b))"), ("max", "(a, b) (((a) > (b)) ? (a) : (b))"), ("near", ""), ("far", ""), ("small", " char"),
    ("interface", " struct")))


def windows_headers(compiler):
    """The options by which clang finds the headers of mingw-w64 and no others."""
    gcc = subprocess.run([f"{MINGW}-g++-posix", "-print-file-name=include"], check=True, capture_output=True, text=True).stdout.strip()
    own = subprocess.run([compiler, "-print-resource-dir"], check=True, capture_output=True, text=True).stdout.strip()
    folders = [f"{gcc}/c++", f"{gcc}/c++/{MINGW}", f"{gcc}/c++/backward", f"{own}/include", f"/usr/{MINGW}/include"]
    return [f"--target={MINGW}", "-nostdinc", *(word for folder in folders for word in ("-isystem", folder))]


def installed_headers(entries):
    """The entries that compile one installed header each (the target headers_alone)."""
    return [entry for entry in entries if "/headers_alone_" in entry["file"] and "Matchers" not in entry["file"]]


def unknown_words(source, entries):
    """Words in installed headers that Visual Studio's compiler does not know, outside comments and branches for other compilers."""
    for entry in installed_headers(entries):
        name = entry["file"].split("/headers_alone_", 1)[1].split("/", 1)[1].removesuffix(".cpp")
        file = pathlib.Path(source, name)
        if name == HAS_A_BRANCH:
            continue
        for number, line in enumerate(file.read_text().splitlines() if file.exists() else (), 1):
            word = UNKNOWN_WORD.search(re.sub(r"//.*", "", line))
            if word:
                yield f"{name}:{number}: Visual Studio does not know {word.group()}"


def behind_windows(source, entries, folder):
    """Pairs of an entry and the header to include first: all that the installed headers include themselves, <windows.h>, and macros."""
    headers = installed_headers(entries)
    others = set()
    for kind in ("plain", "bullet"):  # those for Bullet include the plain ones
        own = [entry for entry in headers if f"/headers_alone_{kind}/" in entry["file"]]
        names = {entry["file"].split(f"/headers_alone_{kind}/", 1)[1].removesuffix(".cpp") for entry in own}
        texts = [pathlib.Path(source, name).read_text() for name in names if pathlib.Path(source, name).exists()]
        others |= {found for text in texts for found in re.findall(r"^#include (<[^>]+>)", text, re.MULTILINE)}
        first = pathlib.Path(folder, f"{kind}.h")
        first.write_text("".join(f"#include {other}\n" for other in [*sorted(others), "<windows.h>"]) + MACROS)
        yield from ((entry, str(first)) for entry in own)


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
    parser.add_argument("--windows", action="store_true")
    for argument in ("source", "build", "this_compiler"):
        parser.add_argument(argument)
    parser.add_argument("folders", nargs="+")
    arguments = parser.parse_args()
    source, build, folders = os.path.abspath(arguments.source), os.path.abspath(arguments.build), arguments.folders
    compiler = arguments.compiler or ("clang++" if arguments.this_compiler == "GNU" else "g++")
    standard = [f"-std={arguments.std}"] if arguments.std else []
    if not shutil.which(compiler):
        print(f"skipped: no {compiler} (apt-get install {compiler.replace('clang++', 'clang')})")
        return SKIPPED
    if arguments.windows and not shutil.which(f"{MINGW}-g++-posix"):
        print(f"skipped: no {MINGW}-g++-posix (bash cmake/setup.sh windows)")
        return SKIPPED
    commands = pathlib.Path(build, "compile_commands.json")
    if arguments.windows and not commands.exists():
        line = ["cmake", "--preset", "windows-mingw", "-B", build, "-DBULLETHAPTICS_ASSIMP=OFF"]
        if subprocess.run(line, cwd=source, stdout=subprocess.DEVNULL, check=False).returncode != 0:
            commands.unlink(missing_ok=True)
            print("skipped: the preset windows-mingw lacks something (bash cmake/setup.sh windows)")
            return SKIPPED
    if not commands.exists():
        print(f"skipped: no {commands}, which generators for Ninja and make write")
        return SKIPPED
    all_entries = json.loads(commands.read_text())
    entries = [(entry, None) for entry in chosen(all_entries, source, folders)]
    target = windows_headers(compiler) if arguments.windows else []
    found = list(unknown_words(source, all_entries)) if arguments.windows else []

    def complaints(pair):
        entry, first = pair
        words = options(entry)
        extra = []
        if first:
            words = [word for word in words if word not in ("-DNOMINMAX", "-DWIN32_LEAN_AND_MEAN")]
            extra = [*HEADER_TRAPS, "-include", first]
        elif target:
            extra = TRAPS
        line = [compiler, *target, *words, *ADDED, *extra, *standard, entry["file"]]
        run = subprocess.run(line, cwd=entry["directory"], capture_output=True, text=True)
        if target and not first and run.returncode == 0:
            return "\n".join(dict.fromkeys(text for text in run.stderr.splitlines() if TRAP.search(text)))
        return run.stderr or (f"{entry['file']}: {compiler} ended with {run.returncode}" if run.returncode else "")

    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        if arguments.windows:
            entries += behind_windows(source, all_entries, folder)
        found += [text for text in pool.map(complaints, entries) if text]
    print("\n".join(found))
    print(f"{compiler} read {len(entries)} sources, {len(found)} with complaints")
    return 1 if found or not entries else 0


if __name__ == "__main__":
    sys.exit(main())
