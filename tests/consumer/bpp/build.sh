#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds the game for bpp.sh twice, from a checkout of it that you have: as it is, and with our lines.
# Usage: build.sh CHECKOUT FOLDER
# CHECKOUT: of bullet-physics-playground, which has the commit 2efed9c. FOLDER/stock and FOLDER/ours are what bpp.sh takes.
# It needs: qtbase5-dev qt5-qmake libqt5opengl5-dev libqglviewer-dev-qt5 libluabind-dev liblua5.2-dev libglew-dev freeglut3-dev
# libsdl2-dev libassimp-dev libbullet-dev pkg-config, and bullethaptics-force in PKG_CONFIG_PATH
set -euo pipefail
[ $# -eq 2 ] || { sed -n 4,5p "$0"; exit 2; }
here=$(cd "$(dirname "$0")" && pwd) checkout=$(cd "$1" && pwd)
mkdir -p "$2/stock"
folder=$(cd "$2" && pwd)

# insert FILE PATTERN SED_COMMAND COUNT: so many lines match, and each gets the line of ours.
insert()
{
	[ "$(grep -cE "$2" "$1")" -eq "$4" ] || { echo "build.sh: $1 has not $4 lines that match $2: is it the commit 2efed9c?" >&2; exit 1; }
	sed -i -E "\\#$2#$3" "$1"
}
build() { (cd "$1" && shift && qmake CONFIG+=release "$@" bpp.pro && make -j"${JOBS:-2}" release); }

git -C "$checkout" archive 2efed9c | tar -x -C "$folder/stock"
rm -rf "$folder/ours"
cp -r "$folder/stock" "$folder/ours"
cp "$here/Volumetric.h" "$folder/ours/src"
insert "$folder/ours/src/viewer.h" '^ *btDiscreteDynamicsWorld \*dynamicsWorld;' 'a std::shared_ptr<Volumetric> volumetric;' 1
insert "$folder/ours/src/viewer.cpp" '^ *btGImpactCollisionAlgorithm::registerAlgorithm\(dispatcher\);' \
	'a volumetric = makeVolumetric(*dynamicsWorld);' 2
insert "$folder/ours/src/viewer.cpp" '^ *delete dynamicsWorld;' 'i volumetric.reset();' 2
insert "$folder/ours/src/viewer.cpp" '^ *dynamicsWorld->stepSimulation\(' 'i updateVolumetric(volumetric.get());' 1
sed -i '1i #include "Volumetric.h"' "$folder/ours/src/viewer.h"
# The game is C++11; ours is not.
g++ -std=c++17 -O2 $(pkg-config --cflags bullethaptics-force) -c "$here/Volumetric.cpp" -o "$folder/ours/volumetric.o"

build "$folder/stock"
build "$folder/ours" -after "LIBS += $folder/ours/volumetric.o $(pkg-config --libs bullethaptics-force)"
echo "$here/bpp.sh $folder/stock $folder/ours $folder/run"
