#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""What becomes of mesh files: builds a tree of each file in some folders and counts the outcomes.

Usage: mesh_outcomes.py IST FOLDER... [-- OPTION...]
    IST is the program `ist`; OPTION... go to `ist build` (default: --spheres 1000). Prints a line for each file and a table.
    Exit code 1 if a file ended the program or an answer was not pure JSON.
"""
import collections
import json
import os
import subprocess
import sys
import tempfile
import time

ENDINGS = (".stl", ".obj", ".ply", ".3mf", ".amf", ".dae", ".fbx", ".x3d", ".glb", ".gltf", ".off", ".3ds", ".blend", ".wrl")
HARMLESS = ("Welded equal positions", "Turned the axes")
SECONDS = 300


def outcome(ist, path, options, out):
    """The class, and what is said about it."""
    try:
        run = subprocess.run([ist, "build", path, "-o", out, "--json", *options], capture_output=True, text=True, timeout=SECONDS,
                             errors="replace", check=False)
    except subprocess.TimeoutExpired:
        return "no answer in time", f"{SECONDS} s"
    said = [line for line in run.stderr.splitlines() if line.startswith("ist: ")]
    if run.returncode == 1 and not run.stdout and said and not os.path.exists(out):
        return "refused", said[-1][5:].replace(path + ": ", "").replace(path + " ", "")
    if run.returncode != 0:
        return "FAILED", f"exit code {run.returncode}: {run.stdout[:80]}"
    try:
        report = json.loads(run.stdout)
    except ValueError:
        return "FAILED", "standard output is not JSON"
    text = f"{report['volume']:.6g} m^3, {report['longest_side']:.6g} m long, in doubt {100 * report['volume_doubt']:.2g} %"
    if report["volume_doubt"] > 0.05:
        return "built, doubt of more than 5 % said" if any("may be off by" in line for line in said) else "FAILED", text
    repaired = [sentence for sentence in report["repair"] if not sentence.startswith(HARMLESS)]
    return ("built after repair" if repaired else "built as it is"), text


def main():
    arguments = sys.argv[1:]
    options = ["--spheres", "1000"]
    if "--" in arguments:
        options = arguments[arguments.index("--") + 1:]
        arguments = arguments[:arguments.index("--")]
    if len(arguments) < 2:
        sys.exit(__doc__)
    count = collections.Counter()
    for folder in arguments[1:]:
        for root, folders, names in os.walk(folder):
            folders.sort()
            for name in sorted(names):
                if not name.lower().endswith(ENDINGS):
                    continue
                with tempfile.TemporaryDirectory() as work:
                    start = time.monotonic()
                    kind, text = outcome(arguments[0], os.path.join(root, name), options, os.path.join(work, "tree.ist"))
                count[kind] += 1
                where = os.path.relpath(os.path.join(root, name), folder)
                print(f"{where}: {kind} in {time.monotonic() - start:.1f} s: {text}", flush=True)
    print("\n| outcome | files |\n|---|---|")
    for kind, number in count.most_common():
        print(f"| {kind} | {number} |")
    return 1 if count["FAILED"] else 0


if __name__ == "__main__":
    sys.exit(main())
