#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""A track of VDrift's with drums on the road, so that a car meets something that gives way. Usage: drums.py TRACK NEW_TRACK

TRACK is a folder of VDrift's data, such as zandvoort, in the older of its two formats (objects/list.txt, objects/objects.jpk).
NEW_TRACK gets the same objects in the newer format, which can have bodies. It also gets two rows of three stacks, of two drums each,
30 m before the first start position, across the way of the car (-x in Bullet's frame).
"""
import math
import pathlib
import shutil
import sys

FIELDS = ("model texture mipmap nolighting skybox alphablend bump_length bump_height driveable collideable friction tread resistance drag "
          "isashadow clampuv surface").split()
RADIUS, HALF_HEIGHT, MASS, SIDES = 0.3, 0.45, 15, 12


def objects_of(text):
    words = [line for line in (line.strip() for line in text.splitlines()) if line and not line.startswith("#")]
    count = int(words.pop(0))
    return [dict(zip(FIELDS, words[i:i + count])) for i in range(0, len(words) - count + 1, count)]


def static_object(index, o):
    lines = [f"[object.{index}]", f"[object.{index}.body]"]
    keys = ("model", "texture", "mipmap", "nolighting", "skybox", "alphablend", "clampuv", "isashadow", "surface")
    lines += [f"{key} = {o[key]}" for key in keys]
    if o["collideable"] == "1" or o["driveable"] == "1":
        lines.append("mass = 0")
    return lines


def drum(name, position):
    lines = [f"[object.{name}]", "position = {:.4f}, {:.4f}, {:.4f}".format(*position),
             f"[object.{name}.body]", "model = street_utility/road_cone.joe",
             "texture = street_utility/road_cone.png", f"mass = {MASS}", f"[object.{name}.body.hull]"]
    for i in range(2 * SIDES):
        angle = 2 * math.pi * (i // 2) / SIDES
        z = HALF_HEIGHT if i % 2 else -HALF_HEIGHT
        lines.append(f"{i:02} = {RADIUS * math.cos(angle):.4f}, {RADIUS * math.sin(angle):.4f}, {z}")
    return lines


def start_of(track):
    for line in (track / "track.txt").read_text().splitlines():
        if line.startswith("start position 0"):
            y, z, x = (float(v) for v in line.split("=")[1].split(","))
            return x, y, z
    sys.exit(f"{track}/track.txt has no start position 0")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    track, new = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    shutil.copytree(track, new, ignore=shutil.ignore_patterns("list.txt*"))
    lines = []
    for i, o in enumerate(objects_of((track / "objects" / "list.txt").read_text())):
        lines += static_object(i, o)
    x, y, _ = start_of(track)
    for row in range(2):
        for column in range(3):
            for level in range(2):
                at = (x - 30 - 1.2 * row, y + 0.9 * (column - 1) + 0.1 * row, 0.05 + HALF_HEIGHT + level * (2 * HALF_HEIGHT + 0.01))
                lines += drum(f"drum{row}{column}{level}", at)
    (new / "objects" / "objects.txt").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
