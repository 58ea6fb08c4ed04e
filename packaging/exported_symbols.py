#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Lists what shared libraries export that is not ours, and fails if there is any. A DLL of mingw-w64 also exports what is inline in headers
of others, as a library for Linux does by weak symbols; of DLLs only what must be hidden is listed (cmake/hidden.map).
Usage: exported_symbols.py LIBRARY ..."""
import fnmatch
import pathlib
import re
import subprocess
import sys

OURS = re.compile(r"(ist(?!::kernels)|devicebridge|bullethaptics|bt[A-Z]\w*)(<.*>)?::|"
                  r"(bt(IST|Volumetric|Contact|Haptic)\w*|meshOfShape|evaluateContactPatch|exertExplicitly|installVolumetricSolver)\b")


def hidden_names():
    """The patterns of cmake/hidden.map for names of C++."""
    text = (pathlib.Path(__file__).resolve().parent.parent / "cmake/hidden.map").read_text()
    block = re.search(r'extern "C\+\+" \{(.*?)\}', text, re.DOTALL).group(1)
    return re.compile("|".join(fnmatch.translate(pattern) for pattern in re.findall(r"([^\s;]+);", block)))


def exported_by_dll(library):
    """The names in the export table of a DLL."""
    text = subprocess.run(["x86_64-w64-mingw32-objdump", "-p", library], check=True, capture_output=True, text=True).stdout
    table = re.search(r"\[Ordinal/Name Pointer\] Table.*?\n(.*?)\n\n", text, re.DOTALL)
    names = re.findall(r"^\s*\[\s*\d+\].*?(\S+)$", table.group(1), re.MULTILINE) if table else []
    return subprocess.run(["c++filt"], input="\n".join(names), check=True, capture_output=True, text=True).stdout.splitlines()


def exported(library):
    """Strong definitions alone: what is inline is defined by whoever uses it."""
    lines = subprocess.run(["nm", "-DC", "--defined-only", library], check=True, capture_output=True, text=True).stdout.splitlines()
    for line in lines:
        kind, name = line.split(maxsplit=2)[1:]
        if kind in "TDBR":
            yield name


def main():
    foreign = []
    hidden = hidden_names()
    for library in sys.argv[1:]:
        if library.endswith(".dll"):
            names = exported_by_dll(library)
            if not any(OURS.match(name) for name in names):
                sys.exit(f"{library} exports nothing of ours")
            found = [name for name in names if hidden.match(name)]
        else:
            found = [name for name in exported(library) if not OURS.match(name)]
        foreign += [f"{pathlib.Path(library).name}: {name}" for name in found]
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if foreign:
        sys.exit("exported, but not ours:\n" + "\n".join(foreign))


main()
