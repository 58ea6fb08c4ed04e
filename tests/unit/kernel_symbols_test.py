#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""A kernel's object defines one symbol, its table: anything else that the linker can see, it could merge with another set's.
Usage: kernel_symbols_test.py NM OBJECT..."""
import subprocess
import sys

# t, r, b, d: local. p: a table of Windows for unwinding, local, too. U: undefined.
# The sanitizers' own variables are the same in every object.
LOCAL = set("trbdp") | {"U"}
bad = []
for path in sys.argv[2:]:
    tables = 0
    for line in subprocess.run([sys.argv[1], "-C", path], check=True, capture_output=True, text=True).stdout.splitlines():
        kind, name = line[16:].strip().split(" ", 1)
        if kind in LOCAL or "__odr_asan" in name or name == "DW.ref.__gxx_personality_v0":
            continue
        if kind in "RDBT" and name.startswith("ist::kernels::k") and name.endswith("Kernel"):
            tables += 1
            continue
        bad.append(f"{path}: {kind} {name}")
    if tables != 1:
        bad.append(f"{path}: {tables} kernel tables")
print("\n".join(bad) or f"{len(sys.argv) - 2} objects, one symbol each")
sys.exit(1 if bad else 0)
