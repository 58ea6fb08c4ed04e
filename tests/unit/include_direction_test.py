#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Data flows one way: a file includes only what stands to its left in the chain, or beside it (ARCHITECTURE.md)."""
import pathlib
import re
import sys

# Each place (a folder, or files whose name begins so) with what it may include from this project. The longest matching prefix counts.
ALLOWED = {
    "BulletISTCollision": ["BulletISTCollision"],
    "BulletISTCollision/Core": ["BulletISTCollision/Core"],
    "BulletISTCollision/Tools": ["BulletISTCollision"],
    "BulletISTCollision/Python": ["BulletISTCollision/Core", "BulletISTCollision/Python"],
    "BulletHapticForce": ["BulletISTCollision", "BulletHapticForce"],
    "TestSupport": ["BulletISTCollision", "BulletHapticForce", "TestSupport"],
    "TestSupport/SceneFiles": ["BulletISTCollision", "BulletHapticForce", "TestSupport/SceneFiles"],
    "DeviceBridge": ["BulletISTCollision/Core", "DeviceBridge"],
    # The commands read their numbers alike.
    "DeviceBridge/Tools": ["BulletISTCollision/Core", "BulletISTCollision/Tools/WholeNumber.h", "DeviceBridge"],
    # The half of DeviceBridge that knows Bullet; the other half must not.
    "DeviceBridge/Bullet": ["BulletISTCollision", "BulletHapticForce", "DeviceBridge"],
    "demos": ["BulletISTCollision", "BulletHapticForce", "TestSupport/SceneFiles", "DeviceBridge", "demos"],
}
# Packages that only files with these names may include.
GUARDED = {
    r"^<assimp/": ["BulletISTCollision/Core/MeshImport.cpp", "BulletISTCollision/Core/MeshReaderWarnings.cpp"],
    r"^<png": ["DeviceBridge/Picture.cpp"],
    r"^<Eigen/": ["BulletISTCollision/Core/MomentEllipsoid.cpp", "BulletISTCollision/Core/PressureField.cpp", "BulletHapticForce/btContactLaw.cpp", "BulletHapticForce/btVolumetricRows.cpp",
                  "BulletHapticForce/btIslandBlockSolver.cpp", "BulletHapticForce/btSweepAcceleration.cpp"],
    r"^<bt|^[<\"](Bullet(Collision|Dynamics)|LinearMath)/": ["BulletISTCollision/bt", "BulletHapticForce/", "TestSupport/SceneFiles/PrincipalMesh", "TestSupport/SceneFiles/SceneWorld", "TestSupport/ContactLog", "TestSupport/Matchers", "TestSupport/Test", "DeviceBridge/Bullet", "demos/"],
}


def rules(path):
    best = max((p for p in ALLOWED if path.startswith(p) and not path[len(p):].startswith(".")), key=len, default=None)
    return ALLOWED.get(best)


def violations(root):
    for folder in ("BulletISTCollision", "BulletHapticForce", "TestSupport", "DeviceBridge", "demos"):
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp"):
                continue
            path = file.relative_to(root).as_posix()
            for number, line in enumerate(file.read_text().splitlines(), 1):
                match = re.match(r'\s*#\s*include\s+([<"][^>"]+)', line)
                if not match:
                    continue
                name = match.group(1)
                if name[0] == '"' and not name[1:].startswith(("BulletCollision/", "BulletDynamics/", "LinearMath/")) and not any(name[1:].startswith(a if a.endswith(".h") else a + "/") for a in rules(path)):
                    yield f"{path}:{number}: may not include {name[1:]}"
                for pattern, files in GUARDED.items():
                    if re.search(pattern, name) and not path.startswith(tuple(files)):
                        yield f"{path}:{number}: may not include {name[1:]}"


found = list(violations(pathlib.Path(sys.argv[1])))
print("\n".join(found) or "every include points the right way")
sys.exit(1 if found else 0)
