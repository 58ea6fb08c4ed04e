#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Lists what shared libraries export that is not ours, and fails if there is any.
Usage: exported_symbols.py LIBRARY ..."""
import pathlib
import re
import subprocess
import sys

OURS = re.compile(r"(ist(?!::kernels)|devicebridge|bullethaptics|bt[A-Z]\w*)(<.*>)?::|"
                  r"(bt(IST|Volumetric|Contact|Haptic)\w*|meshOfShape|evaluateContactPatch|exertExplicitly|installVolumetricSolver)\b")

def exported(library):
    """Strong definitions alone: what is inline is defined by whoever uses it."""
    lines = subprocess.run(["nm", "-DC", "--defined-only", library], check=True, capture_output=True, text=True).stdout.splitlines()
    for line in lines:
        kind, name = line.split(maxsplit=2)[1:]
        if kind in "TDBR":
            yield name


def main():
    foreign = [f"{pathlib.Path(library).name}: {name}" for library in sys.argv[1:] for name in exported(library)
               if not OURS.match(name)]
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if foreign:
        sys.exit("exported, but not ours:\n" + "\n".join(foreign))


main()
