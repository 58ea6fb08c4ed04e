#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Runs the Python blocks of a page in order, as one program, in a folder of its own. Usage: run_python.py PAGE"""
import os
import pathlib
import re
import sys
import tempfile

page = pathlib.Path(sys.argv[1]).resolve()
text = page.read_text()
program = "\n" * text.count("\n")
for match in re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S):
    first = text[:match.start()].count("\n") + 1
    lines = program.split("\n")
    lines[first:first + match.group(1).count("\n")] = match.group(1).splitlines()
    program = "\n".join(lines)
if not program.strip():
    sys.exit(f"{page} has no block of Python")
with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    exec(compile(program, str(page), "exec"), {"__name__": "__main__"})
