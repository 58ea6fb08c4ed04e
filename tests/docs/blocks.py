#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Writes the C++ blocks of Markdown pages as source files, one for each run of blocks that belong together.

A block that begins with ```cpp file is a whole file. ```cpp in: ARGUMENTS is the body of a function with these arguments.
```cpp more goes on in the function of the block before it. ```cpp alone is refused: a page must say how its block is to be read.
A table below the comment <!-- cpp in: ARGUMENTS --> has statements in its second column. Each `...;` there is compiled, and each row has
its own scope.
Usage: blocks.py FOLDER PAGE...
"""
import pathlib
import re
import sys

PREAMBLE = """#include "BulletHapticForce/btBulletHapticForceCommon.h"
#include "BulletISTCollision/Core/Asset/AssetFile.h"
#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Mesh/MeshDivision.h"
#include "BulletISTCollision/Core/Import/MeshFileVertices.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MatchingVertices.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Build/TreeBuilder.h"
#include "BulletISTCollision/Core/Build/TreeCache.h"
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Bullet/BulletDecoupledSource.h"
#include "DeviceBridge/Bullet/BulletHand.h"
#include "DeviceBridge/Bullet/BulletHandSource.h"
#include "DeviceBridge/Bullet/BulletHeatMap.h"
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"
#include "DeviceBridge/Hand/Grasp/GraspQuality.h"
#include "DeviceBridge/Hand/HandMotion.h"
#include "DeviceBridge/Hand/HandPosture.h"
#include "DeviceBridge/Hand/Grasp/HeatMapFile.h"
#include "DeviceBridge/Hand/Grasp/HeatMapTexture.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "TestSupport/Matchers.h"
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <gtest/gtest.h>
using namespace ist::test;
"""
# Bullet's loader of .bullet files, which need not be installed.
IMPORTER = "#include <BulletWorldImporter/btBulletWorldImporter.h>\n"


def blocks(page):
    """Yields the first line, the words after ```cpp, and the text of each block."""
    for match in re.finditer(r"^```cpp([^\n]*)\n(.*?)^```", page.read_text(), re.M | re.S):
        yield page.read_text()[:match.start()].count("\n") + 2, match.group(1).strip(), match.group(2)


def function(page, line, arguments, body):
    """A source with one function around `body`."""
    name = f"block_{line}"
    importer = IMPORTER if "btBulletWorldImporter" in body else ""
    return f"{importer}{PREAMBLE}void {name}({arguments});\nvoid {name}({arguments})\n{{\n{body}}}\n"


def tables(page):
    """The sources of a page's tables of statements."""
    text = page.read_text()
    for match in re.finditer(r"^<!-- cpp in: ([^\n]+) -->\n((?:\|[^\n]*\n)+)", text, re.M):
        first = text[:match.start()].count("\n") + 2
        body = ""
        for line, row in enumerate(match.group(2).splitlines(), first):
            statements = re.findall(r"`([^`]+;)`", row.split("|")[2])
            if statements:
                body += f'#line {line} "{page}"\n{{ {" ".join(statements)} }}\n'
        if not body:
            sys.exit(f"{page}:{first}: no row of this table has a statement in its second column")
        yield function(page, first, match.group(1), body)


def write(folder, page):
    sources = []
    for line, how, text in blocks(page):
        at = f'#line {line} "{page}"\n'
        if how == "file":
            sources.append(at + text)
        elif how == "more" and sources:
            sources[-1] = sources[-1].removesuffix("}\n") + at + text + "}\n"
        elif how.startswith("in:"):
            sources.append(function(page, line, how.removeprefix("in:").strip(), at + text))
        else:
            sys.exit(f"{page}:{line}: say how this block is to be compiled: ```cpp file, ```cpp in: ARGUMENTS, or ```cpp more")
    for number, source in enumerate([*sources, *tables(page)]):
        (folder / f"{page.stem}_{number}.cpp").write_text(source)


folder = pathlib.Path(sys.argv[1])
folder.mkdir(parents=True, exist_ok=True)
for name in sys.argv[2:]:
    write(folder, pathlib.Path(name))
