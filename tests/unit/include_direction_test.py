#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Data flows one way: a file includes only headers of folders that stand before its own in the chain (ARCHITECTURE.md).

Each row below is one folder and the folders that its files may include. The rows stand in the order of the chain, and the test fails when
a row names a folder that comes after it, when a folder has no row, or when a folder holds more files than a reader can look through.
"""
import collections
import pathlib
import re
import sys

CORE = "BulletISTCollision/Core/"
JSON = "BulletISTCollision/Json"
VENDORS = "tests/unit/DeviceBridge/vendors"  # stand-ins for headers of others, with the includes that those have
SUPPORT = ["BulletISTCollision", "BulletHapticForce", "TestSupport/SceneFiles"]
ALL = ["BulletISTCollision", "BulletHapticForce", "TestSupport/SceneFiles", "DeviceBridge"]
# A folder and what it may include beside itself. A name stands for the folder and all folders in it.
CHAIN = [
    # Core: from a mesh to the force between two trees.
    (CORE + "Base", []),
    # What the system does. Each folder Platform has headers, and in Posix and Windows the sources of both kinds of system.
    (CORE + "Platform", [CORE + "Base"]),
    (CORE + "Geometry", [CORE + "Base"]),
    (CORE + "Mesh", [CORE + "Base"]),
    (CORE + "Import/Formats", [CORE + "Base", CORE + "Mesh"]),
    (CORE + "Import", [CORE + "Base", CORE + "Platform", CORE + "Mesh", CORE + "Import/Formats"]),
    ("BulletISTCollision/Importer", [CORE + "Base", CORE + "Platform", CORE + "Mesh", CORE + "Import"]),
    (CORE + "Distance", [CORE + "Base", CORE + "Mesh"]),
    (CORE + "Repair", [CORE + "Base", CORE + "Mesh", CORE + "Distance"]),
    (CORE + "Packing", [CORE + "Base", CORE + "Geometry", CORE + "Mesh", CORE + "Distance"]),
    (CORE + "Leaves", [CORE + "Base", CORE + "Geometry", CORE + "Mesh", CORE + "Distance"]),
    (CORE + "Surface", [CORE + "Base", CORE + "Mesh", CORE + "Distance"]),
    (CORE + "Surface/Partition", [CORE + "Base", CORE + "Mesh", CORE + "Distance", CORE + "Surface"]),
    (CORE + "Tree", [CORE + "Base", CORE + "Geometry", CORE + "Mesh", CORE + "Leaves", CORE + "Surface"]),
    (CORE + "Asset", [CORE + "Base", CORE + "Platform", CORE + "Surface", CORE + "Tree"]),
    (CORE + "Query/Kernels", [CORE + "Base", CORE + "Surface", CORE + "Tree"]),
    (CORE + "Faces", [CORE + "Base", CORE + "Surface", CORE + "Query/Kernels"]),
    (CORE + "Query", [CORE + "Base", CORE + "Geometry", CORE + "Surface", CORE + "Tree", CORE + "Query/Kernels", CORE + "Faces"]),
    (CORE + "Force", [CORE + "Base", CORE + "Tree", CORE + "Faces", CORE + "Query"]),
    (CORE + "Accuracy", [CORE + "Tree", CORE + "Query", CORE + "Force"]),
    (CORE + "Build", [CORE + f for f in ("Base", "Platform", "Mesh", "Repair", "Packing", "Leaves", "Surface", "Tree", "Asset",
                                         "Accuracy")]),
    (CORE + "Tuning", [CORE + f for f in ("Base", "Mesh", "Tree", "Force", "Accuracy", "Build")]),
    # The Bullet side: from a shape's tree to the contact of a pair in Bullet's dispatcher.
    ("BulletISTCollision/Registry", [CORE]),
    ("BulletISTCollision/Contact", [CORE, "BulletISTCollision/Registry"]),
    ("BulletISTCollision/PairQuery", [CORE, "BulletISTCollision/Registry", "BulletISTCollision/Contact"]),
    ("BulletISTCollision/Dispatch", [CORE, "BulletISTCollision/Registry", "BulletISTCollision/Contact", "BulletISTCollision/PairQuery"]),
    ("BulletISTCollision", ["BulletISTCollision"]),
    ("BulletISTCollision/Json", []),
    ("BulletISTCollision/Tools/Platform", [CORE, "BulletISTCollision/Tools"]),
    ("BulletISTCollision/Tools", ["BulletISTCollision"]),
    ("BulletISTCollision/Python", [CORE]),
    # From contacts to impulses.
    ("BulletHapticForce/Law", ["BulletISTCollision"]),
    ("BulletHapticForce/Solver", ["BulletISTCollision", "BulletHapticForce/Law"]),
    ("BulletHapticForce/World", ["BulletISTCollision", "BulletHapticForce/Law", "BulletHapticForce/Solver"]),
    ("BulletHapticForce", ["BulletISTCollision", "BulletHapticForce"]),
    ("BulletHapticForce/Preload", ["BulletISTCollision", "BulletHapticForce"]),
    ("TestSupport/SceneFiles", ["BulletISTCollision", "BulletHapticForce"]),
    ("TestSupport", SUPPORT),
    # From a device's state to a force at the hand. Only the folder Bullet knows a world.
    ("DeviceBridge/Timing", [CORE + "Base"]),
    ("DeviceBridge/Platform", [CORE, "DeviceBridge/Timing"]),
    ("DeviceBridge/Device", [CORE, "DeviceBridge/Timing", "DeviceBridge/Platform"]),
    ("DeviceBridge/Safety", [CORE, "DeviceBridge/Device"]),
    ("DeviceBridge/Decorators", [CORE, "DeviceBridge/Device", "DeviceBridge/Safety"]),
    ("DeviceBridge/Plugins", [CORE, "DeviceBridge/Timing", "DeviceBridge/Platform", "DeviceBridge/Device"]),
    ("DeviceBridge/Drivers/Glove", [CORE, JSON, "DeviceBridge/Timing", "DeviceBridge/Platform", "DeviceBridge/Device",
                                    "DeviceBridge/Drivers/BuiltDrivers.h", "DeviceBridge/Drivers/DeviceRegistry.h"]),
    ("DeviceBridge/Hand/Grasp", [CORE, "DeviceBridge/Hand"]),
    ("DeviceBridge/Hand", [CORE, JSON, "DeviceBridge/Timing", "DeviceBridge/Device", "DeviceBridge/Drivers/Glove"]),
    ("DeviceBridge/Drivers", [CORE, JSON] + ["DeviceBridge/" + f for f in ("Timing", "Platform", "Device", "Safety", "Decorators",
                                                                            "Plugins", "Hand")]),
    ("DeviceBridge/Loop", [CORE] + ["DeviceBridge/" + f for f in ("Timing", "Platform", "Device", "Safety")]),
    ("DeviceBridge/Coupling", [CORE] + ["DeviceBridge/" + f for f in ("Timing", "Device", "Safety", "Drivers", "Loop")]),
    ("DeviceBridge/Bullet", ["BulletISTCollision", "BulletHapticForce"]
     + ["DeviceBridge/" + f for f in ("Timing", "Platform", "Device", "Safety", "Drivers", "Hand", "Loop", "Coupling")]),
    ("DeviceBridge/Tools", [CORE, JSON, "BulletISTCollision/Tools/IntegerArgument.h", "BulletISTCollision/Tools/UnknownCommand.h",
                            "DeviceBridge"]),
    # What shows and judges the chain.
    ("demos/hello", ALL),
    ("demos/scenes/Pages", ALL),
    ("demos/scenes/Bodies", ALL),
    ("demos/scenes/Truth", ALL + ["demos/scenes/Pages", "demos/scenes/Bodies"]),
    ("demos/scenes/Extremes", ALL + ["demos/scenes/Pages", "demos/scenes/Bodies", "demos/scenes/Truth"]),
    ("demos/scenes/Scene", ALL + ["demos/scenes/Pages", "demos/scenes/Bodies"]),
    ("demos/scenes/Assembly", ALL + ["demos/scenes/Pages", "demos/scenes/Scene"]),
    ("demos/scenes/Study", ALL + ["demos/scenes/Pages", "demos/scenes/Scene"]),
    ("demos/scenes/Grasp", ALL + ["demos/scenes/Pages", "demos/scenes/Bodies"]),
    ("demos/scenes/Carry", ALL + ["demos/scenes/Pages", "demos/scenes/Grasp"]),
    ("demos/scenes/HapticBunny", ALL + ["demos/scenes/" + f for f in ("Pages", "Bodies", "Truth", "Extremes")]),
    ("demos/browser/drawing", ALL),
    ("demos/browser/base", ALL + ["demos/scenes", "demos/browser/drawing"]),
    ("demos/browser/catalog", ALL + ["demos/scenes", "demos/browser/drawing", "demos/browser/base"]),
    ("demos/browser/demos", ALL + ["demos/scenes"] + ["demos/browser/" + f for f in ("drawing", "base", "catalog")]),
    ("demos/browser/render", ALL + ["demos/browser/drawing", "demos/browser/base"]),
    ("demos/browser/view", ALL + ["demos/scenes"] + ["demos/browser/" + f for f in ("drawing", "base", "catalog", "render")]),
    ("demos", ALL + ["demos"]),
    # A test's folder is that of what it tests: it may include this library and those before it, and the folders of tests before it.
    ("tests/unit", [CORE]),
    ("tests/unit/Core/Geometry", [CORE, "tests/unit/*.h"]),
    ("tests/unit/Core/Mesh", [CORE, "tests/unit/*.h"]),
    ("tests/unit/Core/Base", [CORE, "tests/unit/*.h", "tests/unit/Core/Mesh"]),
    ("tests/unit/Core/Import", [CORE, "BulletISTCollision/Importer", "tests/unit/*.h"]),
    ("tests/unit/Core/Distance", [CORE, "tests/unit/*.h"]),
    ("tests/unit/Core/Repair", [CORE, "tests/unit/*.h", "tests/unit/Core/Mesh"]),
    ("tests/unit/Core/Packing", [CORE, "tests/unit/*.h"]),
    ("tests/unit/Core/Query", [CORE, "tests/unit/*.h", "tests/unit/Core/Geometry", "tests/unit/Core/Mesh"]),
    ("tests/unit/Core/Leaves", [CORE, "tests/unit/*.h", "tests/unit/Core/Query"]),
    ("tests/unit/Core/Surface", [CORE, "tests/unit/*.h"]),
    ("tests/unit/Core/Tree", [CORE, "tests/unit/*.h", "tests/unit/Core/Mesh", "tests/unit/Core/Query"]),
    ("tests/unit/Core/Asset", [CORE, "tests/fuzz", "tests/unit/*.h", "tests/unit/Core/Tree"]),
    ("tests/unit/Core/Force", [CORE, "tests/unit/*.h", "tests/unit/Core/Mesh", "tests/unit/Core/Query"]),
    ("tests/unit/Core/Accuracy", [CORE, "tests/unit/*.h", "tests/unit/Core/Query"]),
    ("tests/unit/Core/Build", [CORE, "tests/unit/*.h"]),
    ("tests/unit/Core/Tuning", [CORE, "tests/unit/*.h"]),
    ("tests/unit/Json", [JSON]),
    ("tests/unit/Tools", ["BulletISTCollision"]),
    ("tests/unit/ISTCollision/Registry", ["BulletISTCollision", "tests/unit/*.h"]),
    ("tests/unit/ISTCollision/Contact", ["BulletISTCollision", "tests/unit/*.h"]),
    ("tests/unit/ISTCollision/PairQuery", ["BulletISTCollision", "tests/unit/*.h"]),
    ("tests/unit/ISTCollision/Dispatch", ["BulletISTCollision", "tests/unit/*.h", "tests/unit/ISTCollision/Registry"]),
    ("tests/unit/HapticForce/Law", ["BulletISTCollision", "BulletHapticForce", "tests/unit/*.h"]),
    ("tests/unit/HapticForce/Solver", ["BulletISTCollision", "BulletHapticForce", "tests/unit/*.h"]),
    ("tests/unit/HapticForce/World", ["BulletISTCollision", "BulletHapticForce", "tests/unit/*.h", "tests/unit/ISTCollision/Registry"]),
    ("tests/unit/TestSupport", SUPPORT + ["TestSupport"]),
    ("tests/unit/DeviceBridge/Timing", ["DeviceBridge"]),
    ("tests/unit/DeviceBridge/Drivers", [CORE, "DeviceBridge", "tests/unit/*.h", VENDORS]),
    ("tests/unit/DeviceBridge/Device", [CORE, "DeviceBridge", "tests/unit/*.h", "tests/unit/DeviceBridge/Drivers"]),
    ("tests/unit/DeviceBridge/Decorators", [CORE, "DeviceBridge", "tests/unit/*.h"]),
    ("tests/unit/DeviceBridge/Safety", [CORE, "DeviceBridge", "tests/unit/*.h"]),
    ("tests/unit/DeviceBridge/Loop", [CORE, "DeviceBridge", "tests/unit/*.h"]),
    ("tests/unit/DeviceBridge/Tools", [CORE, "DeviceBridge", "tests/unit/*.h"]),
    ("tests/unit/DeviceBridge/Hand", [CORE, "DeviceBridge", "tests/unit/*.h"]),
    ("tests/unit/DeviceBridge/Hand/Grasp", [CORE, "DeviceBridge", "tests/unit/*.h", "tests/unit/DeviceBridge/Hand"]),
    ("tests/unit/DeviceBridge/Bullet", ALL + ["tests/unit/*.h", "tests/unit/DeviceBridge/Hand"]),
    ("tests/unit/DeviceBridge/Coupling", ALL + ["tests/unit/*.h", "tests/unit/DeviceBridge/Bullet"]),
    ("tests/unit/scenes", ALL + ["demos/scenes", "tests/unit/*.h"]),
    ("tests/unit/Browser", ALL + ["demos", "tests/EachDemo.h", "tests/unit/*.h", "tests/unit/Core/Mesh",
                                  "tests/unit/DeviceBridge/Drivers"]),
]
# Packages that only files whose paths begin so may include.
GUARDED = {
    r"^<assimp/": ["BulletISTCollision/Importer/", "tests/"],
    r"^<nlohmann/": ["BulletISTCollision/Json/JsonValue.cpp", "tests/"],
    r"^<png": ["DeviceBridge/Hand/Grasp/Picture.cpp"],
    r"^<Eigen/": [CORE + "Geometry/MomentEllipsoid.cpp", CORE + "Force/PressureField.cpp", "BulletHapticForce/Law/btContactLaw.cpp",
                  "BulletHapticForce/Solver/", "tests/"],
    r"^<bt|^[<\"](Bullet(Collision|Dynamics)|LinearMath)/":
        ["BulletISTCollision/" + f for f in ("Registry/", "Contact/", "PairQuery/", "Dispatch/")]
        + ["BulletHapticForce/", "TestSupport/", "DeviceBridge/Bullet/", "demos/", "tests/"],
}
MOST_FILES = 30  # in a folder
ROOTS = ("BulletISTCollision", "BulletHapticForce", "TestSupport", "DeviceBridge", "demos", "tests/unit")
BULLET = ("BulletCollision/", "BulletDynamics/", "LinearMath/")
ROWS = {place: i for i, (place, _) in enumerate(CHAIN)}


def place_of(path):
    """The innermost folder of `path` that has a row, or None."""
    folder = pathlib.PurePosixPath(path).parent
    while str(folder) not in ROWS and str(folder) != ".":
        folder = folder.parent
    return str(folder) if str(folder) in ROWS else None


def is_within(header, allowed):
    if allowed.endswith("/*.h"):
        return str(pathlib.PurePosixPath(header).parent) == allowed[:-4]
    return header == allowed or header.startswith(allowed.rstrip("/") + "/")


def faults_of_chain():
    for i, (place, may) in enumerate(CHAIN):
        for allowed in may:
            if allowed in ROWS and ROWS[allowed] > i and not allowed.startswith(place + "/") and not place.startswith(allowed):
                yield f"{place} stands before {allowed}, which it may include"


def faults_of_file(path, text):
    place = place_of(path)
    if place is None:
        yield f"{path}: its folder has no row in CHAIN"
        return
    may = CHAIN[ROWS[place]][1]
    for number, line in enumerate(text.splitlines(), 1):
        match = re.match(r'\s*#\s*include\s+([<"])([^>"]+)', line)
        if not match:
            continue
        header, name = match.group(2), match.group(1) + match.group(2)
        if match.group(1) == '"' and not header.startswith(BULLET):
            if place_of(header) != place and not any(is_within(header, a) for a in may):
                yield f"{path}:{number}: may not include {header}"
        for pattern, files in GUARDED.items():
            if re.search(pattern, name) and not path.startswith(tuple(files)):
                yield f"{path}:{number}: may not include {header}"


def faults(root):
    yield from faults_of_chain()
    count = collections.Counter()
    for folder in ROOTS:
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            path = file.relative_to(root).as_posix()
            if path.startswith(VENDORS):
                continue
            count[str(pathlib.PurePosixPath(path).parent)] += 1
            yield from faults_of_file(path, file.read_text())
    for folder, files in sorted(count.items()):
        if files > MOST_FILES:
            yield f"{folder}: {files} files, more than {MOST_FILES}"


if __name__ == "__main__":
    found = list(faults(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or f"every include of {len(CHAIN)} folders points the right way")
    sys.exit(1 if found else 0)
