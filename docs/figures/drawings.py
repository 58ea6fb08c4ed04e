#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Draws pipeline.svg and threads.svg (ARCHITECTURE.md), glossary.svg (docs/glossary.md) and repair.svg (docs/meshes.md) beside this file.
Usage: drawings.py"""
import math
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
INK, QUIET, BLUE, GREEN, ORANGE, VIOLET = "#222", "#777", "#2f6db5", "#3b8f4f", "#c8741a", "#7a4fa3"


class Drawing:
    """An SVG on a light panel, so that it is readable on dark pages, too."""

    def __init__(self, width, height, label):
        self.width, self.height, self.label, self.parts = width, height, label, []

    def add(self, text):
        self.parts.append(text)

    def text(self, x, y, words, size=13, fill=INK, anchor="start", weight="normal"):
        words = words.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
        self.add(f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" fill="{fill}" text-anchor="{anchor}" '
                 f'font-weight="{weight}">{words}</text>')

    def line(self, points, stroke=INK, width=1.5, arrow=False, dash=""):
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        end = f' marker-end="url(#{stroke.strip("#")})"' if arrow else ""
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        self.add(f'<polyline points="{path}" fill="none" stroke="{stroke}" stroke-width="{width}"{dashes}{end}/>')

    def polygon(self, points, fill="none", stroke=INK, width=1.5, opacity=1):
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self.add(f'<polygon points="{path}" fill="{fill}" fill-opacity="{opacity}" stroke="{stroke}" stroke-width="{width}"/>')

    def circle(self, x, y, r, fill="none", stroke=INK, width=1, opacity=1):
        self.add(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" fill="{fill}" fill-opacity="{opacity}" '
                 f'stroke="{stroke}" stroke-width="{width}"/>')

    def ellipse(self, x, y, a, b, degrees, fill="none", stroke=INK, width=1, opacity=1):
        self.add(f'<ellipse cx="0" cy="0" rx="{a:.1f}" ry="{b:.1f}" transform="translate({x:.1f} {y:.1f}) rotate({degrees:.1f})" '
                 f'fill="{fill}" fill-opacity="{opacity}" stroke="{stroke}" stroke-width="{width}"/>')

    def write(self, name):
        arrows = "".join(f'<marker id="{colour.strip("#")}" viewBox="0 0 10 10" refX="9" refY="5" '
                         f'markerWidth="7" markerHeight="7" orient="auto">'
                         f'<path d="M0 0L10 5L0 10z" fill="{colour}"/></marker>' for colour in (INK, QUIET, BLUE, GREEN, ORANGE, VIOLET))
        head = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}" role="img" '
                f'aria-label="{self.label}" font-family="sans-serif">\n<defs>{arrows}</defs>\n'
                f'<rect width="{self.width}" height="{self.height}" rx="8" fill="#fff"/>\n')
        (HERE / name).write_text(head + "\n".join(self.parts) + "\n</svg>\n")


# The pipeline: a station is (folder, what it gives).
LANES = [
    ("Once, offline: BulletISTCollision/Core", BLUE, [
        ("Import", "triangles [m]"), ("Repair", "a closed mesh"), ("Packing", "spheres"), ("Leaves", "leaves"),
        ("Tree", "tree, levels"), ("Asset", ".ist file")]),
    ("A query: BulletISTCollision/Core", GREEN, [
        ("Query", "integrals per patch"), ("Force", "wrench, K, sigma"), ("Accuracy", "level for a tolerance")]),
    ("A step of the world: BulletISTCollision and BulletHapticForce", ORANGE, [
        ("Registry", "shape to tree"), ("Dispatch", "pair to algorithm"), ("PairQuery", "ask, or reuse"),
        ("Contact", "contact store"), ("Law", "wrench, K, D"), ("Solver", "impulses"), ("World", "motion")]),
    ("A tick of the hand, 1 kHz: DeviceBridge", VIOLET, [
        ("Device", "pose of the hand"), ("Loop", "one tick"), ("Coupling", "pull on the tool"), ("Bullet", "tool and contacts"),
        ("Safety", "limited force"), ("Device", "force at the hand")]),
]


def pipeline():
    step, width, height, lane = 152, 126, 56, 132
    drawing = Drawing(1100, 524, "From a mesh to the force at a hand: four lanes of stations")
    places = {}
    for row, (title, colour, stations) in enumerate(LANES):
        y = 46 + row * lane
        at, anchor = (1062, "end") if row == 2 else (24, "start")
        drawing.text(at, y - 14, title, 14, colour, anchor, "bold")
        for column, (folder, gives) in enumerate(stations):
            x = 24 + column * step + (2 * step if row == 1 else 0)
            places[row, column] = (x, y)
            drawing.add(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="6" fill="{colour}" fill-opacity="0.09" '
                        f'stroke="{colour}" stroke-width="1.5"/>')
            drawing.text(x + width / 2, y + 23, folder, 15, INK, "middle", "bold")
            drawing.text(x + width / 2, y + 43, gives, 11, "#444", "middle")
            if column:
                drawing.line([(x - step + width, y + height / 2), (x - 3, y + height / 2)], colour, 2, True)

    def joint(a, b, words, at, side="start", back=False, shift=0, colour=QUIET):
        (xa, ya), (xb, yb) = places[a], places[b]
        x, middle = xa + width / 2 + shift, (ya + height + yb) / 2
        xb += width / 2 + shift
        points = [(x, ya + height), (x, middle + at), (xb, middle + at), (xb, yb - 3)]
        if back:
            points = [(xb, yb), (xb, middle + at), (x, middle + at), (x, ya + height + 3)]
        drawing.line(points, colour, 1.5, True, "5 3")
        drawing.text((x + xb) / 2 + (8 if side == "start" else -8), middle + at - 5, words, 11, QUIET, side)

    joint((0, 5), (1, 0), "tree", -8)
    joint((1, 0), (2, 2), "integrals", -12, shift=26)
    joint((1, 0), (2, 2), "two trees, pose", -12, "end", True, -26)
    x, y = places[0, 5]
    points = [(x + width, y + height / 2), (1078, y + height / 2), (1078, 264), (14, 264), (14, 338), (21, 338)]
    drawing.line(points, QUIET, 1.5, True, "5 3")
    drawing.text(1070, 258, "tree of a shape", 11, QUIET, "end")
    joint((2, 6), (3, 3), "bodies near the tool", 4, shift=20)
    joint((2, 6), (3, 3), "impulses of the tool", -14, "end", True, -20)
    drawing.write("pipeline.svg")


def box(drawing, x, y, width, height, colour, lines, dash=""):
    dashes = f' stroke-dasharray="{dash}"' if dash else ""
    drawing.add(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="6" fill="{colour}" fill-opacity="0.09" '
                f'stroke="{colour}" stroke-width="1.5"{dashes}/>')
    for i, words in enumerate(lines):
        size, fill, weight = (14, INK, "bold") if i == 0 else (11, "#444", "normal")
        drawing.text(x + width / 2, y + 21 + 16 * i, words, size, fill, "middle", weight)


# Threads of a world beside the hand. A thread is (name, colour, what it does); between two of them is what they exchange.
THREADS = [
    ("Device", QUIET, ["only where calls may block", "ThreadedDevice: exchange", "samples and commands"]),
    ("Hand, 1 kHz", VIOLET, ["SteppingThread: one tick, below", "copies of the bodies near the tool,", "linear models of their contacts"]),
    ("Contacts", GREEN, ["only with contact-thread", "queries at the pose asked for", "up to 1 kHz, as they last"]),
    ("World, 60 Hz", ORANGE, ["BulletWorldCoupling::step:", "impulses in, step of the world,", "bodies near the tool out"]),
]
# A tick: (stage, what it has, the event after it, the cause of zero that it may give).
STAGES = [
    ("Read", "Device::read", "", ""),
    ("Trust", "SampleMonitor", "onTransform", "frozen, jump, lost"),
    ("Pull", "GapBridge, spring", "", ""),
    ("World", "ContactSource", "onCollision", "tool not finite"),
    ("Law", "ForceLaw", "onHapticTick", "hook threw"),
    ("Limit", "SafetyLimiter", "", "not finite, too old"),
    ("Write", "Device::write", "onFault", "refused"),
]


def threads():
    drawing = Drawing(1100, 560, "Above: the threads of a hand beside a world. Below: one tick from device to device")
    drawing.text(24, 32, "Threads: none waits for another, and each exchange is a buffer without locks", 14, INK, weight="bold")
    width, height, step, top = 210, 76, 282, 52
    for i, (name, colour, lines) in enumerate(THREADS):
        box(drawing, 24 + i * step, top, width, height, colour, [name, *lines], "6 4" if lines[0].startswith("only") else "")
    y = top + height / 2

    def exchange(i, there, back):
        x = 24 + i * step + width
        drawing.line([(x + 3, y - 10), (x + step - width - 3, y - 10)], INK, 1.5, True)
        drawing.line([(x + step - width - 3, y + 10), (x + 3, y + 10)], INK, 1.5, True)
        drawing.text(x + (step - width) / 2, y - 16, there, 11, QUIET, "middle")
        drawing.text(x + (step - width) / 2, y + 24, back, 11, QUIET, "middle")

    exchange(0, "pose", "force")
    exchange(1, "question", "answer")
    left, right, low = 24 + 1.5 * step - 36, 24 + 3 * step + width / 2, top + height
    for x, dy, words, back in ((0, 26, "bodies near the tool, and what carries them (WorldMirror)", True),
                               (-30, 52, "sums of the impulses that the hand gave to each body", False)):
        points = [(left - 60 + x, low + 3), (left - 60 + x, low + dy), (right + x, low + dy), (right + x, low + 3)]
        if back:
            points = points[::-1]
        drawing.line(points, INK, 1.5, True)
        drawing.text((left + right) / 2, low + dy - 5, words, 11, QUIET, "middle")

    y = 226
    drawing.text(24, y, "With the topology one-thread the hand's thread owns the world: \u201cWorld\u201d below is a step of it. "
                 "With force-thread \u201cLaw\u201d has a thread of its own.", 12, QUIET)
    y += 38
    drawing.text(24, y, "One tick, from device to device", 14, VIOLET, weight="bold")
    width, step, top, height = 116, 152, y + 18, 60
    for i, (name, what, event, cause) in enumerate(STAGES):
        x = 24 + i * step
        box(drawing, x, top, width, height, VIOLET, [name, what])
        if i + 1 < len(STAGES):
            drawing.line([(x + width, top + height / 2), (x + step - 3, top + height / 2)], VIOLET, 2, True)
        if event:
            drawing.line([(x + width / 2, top + height), (x + width / 2, top + height + 26)], BLUE, 1.5, True)
            drawing.text(x + width / 2, top + height + 42, event, 13, BLUE, "middle", "bold")
        if cause:
            middle, below = x + width / 2, top + height
            drawing.line([(middle, below + (52 if event else 0)), (middle, below + 92)], ORANGE, 1.2, False, "4 3")
            drawing.text(x + width / 2, top + height + 110, cause, 11, ORANGE, "middle")
    low = top + height + 122
    drawing.line([(24 + step + width / 2, low), (24 + 6 * step + width / 2, low)], ORANGE, 1.2)
    drawing.line([(24 + 5.5 * step + width / 2, low), (24 + 5.5 * step + width / 2, low + 22)], ORANGE, 1.5, True)
    drawing.text(24 + 5.5 * step + width / 2, low + 38, "zero force, and onFault says why", 13, ORANGE, "middle", "bold")
    drawing.text(24, low + 38, "Blue: events, to which a program adds its functions. They run in the tick.", 12, QUIET)
    drawing.text(24, low + 56, "With several hands in one loop all are read and pull before the world takes its step.", 12, QUIET)
    drawing.write("threads.svg")


# The body of the glossary, in the units of its panels, and what the library would make of it in the plane.
BODY = [(20, 30), (120, 12), (215, 40), (240, 105), (190, 150), (150, 108), (105, 118), (70, 160), (18, 120)]


def nearest(p, body=BODY):
    """Distance to the outline, and the outward normal there."""
    best = (math.inf, (0, 0))
    for (ax, ay), (bx, by) in zip(body, body[1:] + body[:1]):
        dx, dy = bx - ax, by - ay
        t = max(0, min(1, ((p[0] - ax) * dx + (p[1] - ay) * dy) / (dx * dx + dy * dy)))
        q = (ax + t * dx, ay + t * dy)
        d = math.dist(p, q)
        if d < best[0]:
            n = ((q[0] - p[0]) / d, (q[1] - p[1]) / d) if d > 1e-9 else (0, 0)
            best = (d, n)
    return best


def inside(p, body=BODY):
    odd = False
    for (ax, ay), (bx, by) in zip(body, body[1:] + body[:1]):
        if (ay > p[1]) != (by > p[1]) and p[0] < (bx - ax) * (p[1] - ay) / (by - ay) + ax:
            odd = not odd
    return odd


GRID = [(x, y) for x in range(16, 244, 2) for y in range(10, 164, 2) if inside((x, y))]
DEPTHS = {p: nearest(p) for p in GRID}


def packing(count):
    """Largest first, each as large as it fits."""
    spheres = []
    free = {p: DEPTHS[p][0] for p in GRID}
    for _ in range(count):
        p = max(free, key=free.get)
        spheres.append((p[0], p[1], free[p]))
        free = {q: min(r, math.dist(p, q) - spheres[-1][2]) for q, r in free.items()}
    return spheres


MANY = packing(40)
SPHERES = MANY[:12]


def owner(p):
    return min(range(len(SPHERES)), key=lambda i: math.dist(p, SPHERES[i][:2]) - SPHERES[i][2])


def moments(points):
    """Centroid, half-axes and angle of the ellipse with these points' moments, and their mean normal."""
    n = len(points)
    cx, cy = sum(p[0] for p in points) / n, sum(p[1] for p in points) / n
    xx, yy, xy = (sum(f(p[0] - cx, p[1] - cy) for p in points) / n for f in (lambda a, b: a * a, lambda a, b: b * b, lambda a, b: a * b))
    mean, rest = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    angle = math.degrees(0.5 * math.atan2(2 * xy, xx - yy))
    normal = tuple(sum(DEPTHS[p][1][k] for p in points) / n for k in (0, 1))
    return cx, cy, 2 * math.sqrt(mean + rest), 2 * math.sqrt(max(mean - rest, 1)), angle, normal


def clusters(points, count, rounds=12):
    """By place and normal, as the library splits."""
    def key(p):
        return (p[0] / 30, p[1] / 30, 1.2 * DEPTHS[p][1][0], 1.2 * DEPTHS[p][1][1])
    centres = [key(points[i * len(points) // count]) for i in range(count)]
    for _ in range(rounds):
        parts = [[] for _ in centres]
        for p in points:
            parts[min(range(count), key=lambda i: math.dist(key(p), centres[i]))].append(p)
        centres = [tuple(sum(key(p)[k] for p in part) / len(part) for k in range(4)) if part else c for part, c in zip(parts, centres)]
    return [part for part in parts if len(part) > 3]


CELLS = [[p for p in GRID if owner(p) == i] for i in range(len(SPHERES))]
PIECES = [piece for i, cell in enumerate(CELLS) for piece in (clusters(cell, 3 if i < 3 else 2) if i < 6 else [cell]) if len(piece) > 3]
LEAVES = [moments(piece) for piece in PIECES]
MERGED = [moments(part) for part in clusters(GRID, 7)]


def outline_of_cell(i):
    """A cell is star-shaped about the centre of its sphere."""
    x, y, _ = SPHERES[i]
    points = []
    for k in range(72):
        c, s, r = math.cos(k * math.pi / 36), math.sin(k * math.pi / 36), 1
        while inside((x + r * c, y + r * s)) and owner((x + r * c, y + r * s)) == i:
            r += 0.5
        points.append((x + r * c, y + r * s))
    return points


def panel(drawing, column, row, title):
    x, y = 20 + 290 * column, 34 + 222 * row
    drawing.text(x, y - 10, title, 15, INK, weight="bold")
    return lambda p: (x + p[0], y + p[1])


def arrow(drawing, at, p, n, length, colour):
    drawing.line([at(p), at((p[0] + length * n[0], p[1] + length * n[1]))], colour, 1.8, True)


def spheres(drawing, at, opacity, balls):
    for x, y, r in balls:
        drawing.circle(*at((x, y)), r, BLUE, BLUE, 1, opacity)


def glossary():
    drawing = Drawing(880, 690, "The words of the glossary, in pictures")
    at = panel(drawing, 0, 0, "packing, inner sphere, fill")
    drawing.polygon([at(p) for p in BODY])
    spheres(drawing, at, 0.3, MANY)
    drawing.text(*at((0, 172)), "fill: blue area over all of it, volume in space", 11, QUIET)

    at = panel(drawing, 1, 0, "gap")
    balls = [(62, 92, 52), (174, 84, 44), (119, 58, 12), (226, 58, 12), (10, 56, 10)]
    drawing.polygon([at(p) for p in ((0, 40), (244, 40), (244, 150), (0, 150))], "#888", "none", 0, 0.08)
    drawing.line([at((0, 40)), at((244, 40))], INK, 2)
    for x, y, r in balls:
        drawing.circle(*at((x, y)), r, BLUE, BLUE, 1, 0.2)
    for px in (26, 98, 140, 205):
        x, y, r = min(balls, key=lambda s: math.dist((px, 40), s[:2]) - s[2])
        d = math.dist((px, 40), (x, y))
        drawing.line([at((px, 40)), at((x + (px - x) * r / d, y + (40 - y) * r / d))], ORANGE, 3)
    drawing.text(*at((0, 28)), "surface", 12)
    drawing.text(*at((0, 172)), "orange: the gaps at four points of the surface", 11, QUIET)

    at = panel(drawing, 2, 0, "cell")
    drawing.polygon([at(p) for p in BODY])
    spheres(drawing, at, 0.15, SPHERES)
    for i in range(len(SPHERES)):
        drawing.polygon([at(p) for p in outline_of_cell(i)], "none" if i != 1 else ORANGE, ORANGE, 1.2, 0.25)
    drawing.text(*at((0, 172)), "each point belongs to its nearest sphere", 11, QUIET)

    at = panel(drawing, 0, 1, "leaf, normal of a leaf")
    drawing.polygon([at(p) for p in BODY])
    for x, y, a, b, angle, n in LEAVES:
        drawing.ellipse(*at((x, y)), a, b, angle, GREEN, GREEN, 1, 0.15)
        arrow(drawing, at, (x, y), n, 22, GREEN)
    drawing.text(*at((0, 172)), "cells, split where their normals differ", 11, QUIET)

    at = panel(drawing, 1, 1, "level, merged ball")
    drawing.polygon([at(p) for p in BODY])
    for x, y, a, b, angle, n in MERGED:
        drawing.ellipse(*at((x, y)), a, b, angle, VIOLET, VIOLET, 1.2, 0.12)
        arrow(drawing, at, (x, y), n, 26, VIOLET)
    drawing.text(*at((0, 172)), "fewer and larger pieces of the same body", 11, QUIET)

    at = panel(drawing, 2, 1, "tree, block")
    names = [("root", 120, 10, 110), ("nodes", 62, 62, 52), ("", 178, 62, 52)]
    for _, x, y, w in names:
        drawing.add(f'<rect x="{at((x - w / 2, y))[0]:.1f}" y="{at((x, y))[1]:.1f}" width="{w}" height="24" rx="4" '
                    f'fill="{BLUE}" fill-opacity="0.12" stroke="{BLUE}"/>')
    drawing.text(*at((120, 27)), "root", 12, INK, "middle")
    for x in (62, 178):
        drawing.text(*at((x, 79)), "node", 12, INK, "middle")
        drawing.line([at((120, 34)), at((x, 59))], QUIET, 1.5)
        for k in (-1, 0, 1):
            drawing.line([at((x, 86)), at((x + 36 * k, 111))], QUIET, 1.2)
            for j in range(3):
                drawing.ellipse(*at((x + 36 * k - 9 + 9 * j, 122)), 4, 8, 30 * j, GREEN, GREEN, 1, 0.2)
    drawing.text(*at((0, 172)), "a node has eight children, a block sixteen leaves", 11, QUIET)

    at = panel(drawing, 0, 2, "pair, lens, lens centroid")
    drawing.ellipse(*at((92, 82)), 72, 40, 20, BLUE, BLUE, 1.2, 0.15)
    cx, cy = at((92, 82))
    drawing.add(f'<clipPath id="lens"><ellipse cx="0" cy="0" rx="72" ry="40" '
                f'transform="translate({cx:.1f} {cy:.1f}) rotate(20)"/></clipPath>')
    cx, cy = at((168, 92))
    drawing.add(f'<g clip-path="url(#lens)"><ellipse cx="0" cy="0" rx="66" ry="34" '
                f'transform="translate({cx:.1f} {cy:.1f}) rotate(-35)" fill="{ORANGE}" fill-opacity="0.6"/></g>')
    drawing.ellipse(cx, cy, 66, 34, -35, GREEN, GREEN, 1.2, 0.15)
    drawing.circle(*at((135, 99)), 3, INK, INK)
    drawing.text(*at((42, 70)), "leaf of A", 12, BLUE)
    drawing.text(*at((180, 78)), "leaf of B", 12, GREEN)
    drawing.text(*at((0, 172)), "orange: lens, dot: its centroid", 11, QUIET)

    at = panel(drawing, 1, 2, "patch, area vector")
    fork = [(30, 16), (210, 16), (210, 116), (160, 116), (160, 62), (80, 62), (80, 116), (30, 116)]
    drawing.polygon([at(p) for p in fork], BLUE, BLUE, 1.5, 0.1)
    drawing.polygon([at(p) for p in ((10, 104), (230, 104), (230, 150), (10, 150))], GREEN, GREEN, 1.5, 0.1)
    for x in (30, 160):
        drawing.polygon([at(p) for p in ((x, 104), (x + 50, 104), (x + 50, 116), (x, 116))], ORANGE, ORANGE, 1, 0.6)
        arrow(drawing, at, (x + 25, 104), (0, -1), 34, ORANGE)
    drawing.text(*at((0, 172)), "two patches; A must move up to leave B", 11, QUIET)

    at = panel(drawing, 2, 2, "depth, pressure field")
    for inset, opacity in ((0, 0.1), (16, 0.14), (32, 0.2), (48, 0.3)):
        if inset < 50:
            x, y = at((16 + inset, 14 + inset))
            drawing.add(f'<rect x="{x:.1f}" y="{y:.1f}" width="{210 - 2 * inset}" height="{130 - 2 * inset}" '
                        f'fill="{BLUE}" fill-opacity="{opacity}" stroke="{BLUE}"/>')
    arrow(drawing, at, (121, 79), (0, -1), 62, ORANGE)
    drawing.text(*at((128, 40)), "normal", 12, ORANGE)
    drawing.text(*at((0, 172)), "darker: deeper, and more pressure", 11, QUIET)
    drawing.write("glossary.svg")

# Sections of meshes before and after repair: the outlines as the file has them, and what becomes of them. An outline is (points, whether it
# is closed, whether its normals point outwards).
def outline(drawing, at, points, closed=True, outwards=True, colour=INK):
    points = points + points[:1] if closed else points
    drawing.line([at(p) for p in points], colour, 2)
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        length = math.hypot(x1 - x0, y1 - y0)
        nx, ny = (y1 - y0) / length, (x0 - x1) / length
        side = 9 if outwards else -9
        middle = ((x0 + x1) / 2, (y0 + y1) / 2)
        drawing.line([at(middle), at((middle[0] + side * nx, middle[1] + side * ny))], ORANGE, 1.5)


def box(x, y, width, height):
    """Clockwise on the page, so that normals to the left of each edge point outwards."""
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]


def area(drawing, at, outlines, colour=BLUE):
    path = " ".join("M" + " L".join("%.1f %.1f" % at(p) for p in points) + " Z" for points in outlines)
    drawing.add(f'<path d="{path}" fill="{colour}" fill-opacity="0.2" fill-rule="evenodd" stroke="{colour}" stroke-width="2"/>')


def repair():
    names = ["a hole", "an inside-out shell,", "a cavity that is filled", "parts that overlap", "open ground"]
    more = ["closed by a fan", "a shell in solid material", "in part", "rebuilt on a grid", "closed downwards"]
    hill = [(10, 62), (35, 48), (60, 40), (85, 52), (110, 46), (134, 60)]
    big, right = box(10, 20, 90, 70), box(52, 38, 82, 66)
    cross = [(10, 20), (100, 20), (100, 38), (134, 38), (134, 104), (52, 104), (52, 90), (10, 90)]
    drawing = Drawing(820, 356, "Five meshes in section, as in the file and after repair")
    drawing.text(16, 26, "as in the file: lines are triangles, ticks their outer side", 14, INK, weight="bold")
    drawing.text(16, 196, "the body that is packed", 14, INK, weight="bold")
    for i in range(5):
        before = lambda p, x=14 + 160 * i: (x + p[0], 40 + p[1])
        after = lambda p, x=14 + 160 * i: (x + p[0], 208 + p[1])
        if i == 0:
            outline(drawing, before, [(90, 20), (134, 20), (134, 104), (10, 104), (10, 20), (40, 20)], closed=False)
            area(drawing, after, [box(10, 20, 124, 84)])
            drawing.line([after((40, 20)), after((65, 20)), after((90, 20))], GREEN, 3)
        elif i == 1:
            outline(drawing, before, box(10, 20, 124, 84), outwards=False)
            outline(drawing, before, box(50, 44, 44, 36), outwards=False, colour=QUIET)
            area(drawing, after, [box(10, 20, 124, 84)])
        elif i == 2:
            outline(drawing, before, box(10, 20, 124, 84))
            outline(drawing, before, box(40, 38, 80, 50), outwards=False)
            outline(drawing, before, box(70, 50, 30, 30))
            area(drawing, after, [box(10, 20, 124, 84), box(40, 38, 80, 50), box(70, 50, 30, 30)])
        elif i == 3:
            outline(drawing, before, big)
            outline(drawing, before, right)
            area(drawing, after, [cross])
        else:
            outline(drawing, before, hill, closed=False)
            area(drawing, after, [hill + [(134, 104), (10, 104)]])
            drawing.line([after((10, 62)), after((10, 104)), after((134, 104)), after((134, 60))], GREEN, 3)
        drawing.text(14 + 160 * i + 72, 330, names[i], 12, INK, "middle")
        drawing.text(14 + 160 * i + 72, 346, more[i], 12, INK, "middle")
    drawing.write("repair.svg")


pipeline()
threads()
glossary()
repair()
