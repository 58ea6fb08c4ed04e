#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Builds the `ist` command once more, with the other of g++ and clang++, and compares every byte of the assets that both make.
Usage: same_assets_test.py SOURCE IST THIS_COMPILER_ID"""
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77


def write_obj(path, vertices, faces):
    lines = ["v %.9g %.9g %.9g" % v for v in vertices] + ["f %d %d %d" % tuple(i + 1 for i in f) for f in faces]
    path.write_text("\n".join(lines) + "\n")


def box(x, y, z):
    vertices = [(a, b, c) for a in (-x, x) for b in (-y, y) for c in (-z, z)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, [f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]


def bent_torus(rings, sides):
    vertices = []
    for i in range(rings):
        for j in range(sides):
            u, v = 2 * math.pi * i / rings, 2 * math.pi * j / sides
            r = 0.4 + 0.12 * math.cos(v)
            vertices.append((r * math.cos(u), r * math.sin(u) + 0.1, 0.12 * math.sin(v) + 0.1 * math.sin(2 * u)))
    at = lambda i, j: (i % rings) * sides + j % sides
    faces = []
    for i in range(rings):
        for j in range(sides):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            faces += [(a, b, c), (a, c, d)]
    return vertices, faces


def build_other(source, compiler, folder):
    options = ["-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_CXX_COMPILER={compiler}", "-DBULLETHAPTICS_TESTS=OFF", "-DBULLETHAPTICS_DEMOS=OFF",
               "-DBULLETHAPTICS_OPENMP=OFF"]  # of which clang has a package of its own; threads change nothing
    subprocess.run(["cmake", "-S", source, "-B", folder, "-G", "Ninja", *options], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", folder, "--target", "ist"], check=True, stdout=subprocess.DEVNULL)
    return next(p for p in pathlib.Path(folder).rglob("ist") if p.is_file())


def main():
    source, ist, compiler_id = sys.argv[1:]
    other = "clang++" if compiler_id == "GNU" else "g++"
    if not shutil.which(other):
        print(f"{other} is not there; apt-get install {'clang' if other == 'clang++' else other}")
        return SKIPPED
    differing = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        commands = [ist, build_other(source, other, folder / "build")]
        for mesh, shape in {"box": box(0.5, 0.35, 0.25), "plate": box(0.5, 0.4, 0.015), "torus": bent_torus(60, 30)}.items():
            write_obj(folder / f"{mesh}.obj", *shape)
            for spheres in (30, 1000, 10000):
                made = []
                for k, command in enumerate(commands):
                    asset = folder / f"{k}.ist"
                    options = ["-o", asset, "--spheres", str(spheres), "--quiet"]
                    subprocess.run([command, "build", folder / f"{mesh}.obj", *options], check=True)
                    made.append(asset.read_bytes())
                same = made[0] == made[1]
                differing += not same
                print(f"{mesh}, {spheres} spheres: {len(made[0])} bytes, {'the same' if same else 'DIFFERENT'}")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
