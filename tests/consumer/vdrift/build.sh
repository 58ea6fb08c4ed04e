#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds the game for vdrift.sh twice, from a checkout of it that you have: as it is, and with our lines.
# Usage: build.sh CHECKOUT FOLDER
# CHECKOUT: of VDrift, which has the commit 3c8741af. FOLDER/stock/build/vdrift and FOLDER/ours/build/vdrift are what vdrift.sh takes.
# It needs: scons g++ libsdl2-dev libvorbis-dev libcurl4-openssl-dev zlib1g-dev libgl-dev libbullet-dev pkg-config,
# and bullethaptics-force in PKG_CONFIG_PATH
set -euo pipefail
[ $# -eq 2 ] || { sed -n 4,5p "$0"; exit 2; }
here=$(cd "$(dirname "$0")" && pwd) checkout=$(cd "$1" && pwd)
mkdir -p "$2/stock"
folder=$(cd "$2" && pwd)

# insert FILE PATTERN SED_COMMAND: one line matches, and gets the line of ours.
insert()
{
	[ "$(grep -cE "$2" "$1")" -eq 1 ] || { echo "build.sh: $1 has not one line that matches $2: is it the commit 3c8741af?" >&2; exit 1; }
	sed -i -E "\\#$2#$3" "$1"
}
build() { (cd "$1" && scons release=1 cache=0 -j"${JOBS:-2}"); }

git -C "$checkout" archive 3c8741af | tar -x -C "$folder/stock"
rm -rf "$folder/ours"
cp -r "$folder/stock" "$folder/ours"
cp "$here/Volumetric.h" "$folder/ours/src"
insert "$folder/ours/src/game.h" '^\s*DynamicsWorld dynamics;' 'a std::shared_ptr<Volumetric> volumetric = makeVolumetric(dynamics);'
insert "$folder/ours/src/game.cpp" '^\s*// Load timer\.' 'i attachVolumetric(*volumetric);'
insert "$folder/ours/src/game.cpp" '^\s*track\.Clear\(\);' 'i detachVolumetric(*volumetric);'
sed -i '1i #include "Volumetric.h"' "$folder/ours/src/game.h"
# The game is C++14; ours is not.
g++ -std=c++17 -O2 $(pkg-config --cflags bullethaptics-force) -c "$here/Volumetric.cpp" -o "$folder/ours/volumetric.o"

build "$folder/stock"
LDFLAGS="$folder/ours/volumetric.o $(pkg-config --libs bullethaptics-force)" build "$folder/ours"
echo "$here/vdrift.sh $folder/stock/build/vdrift $folder/ours/build/vdrift DATA $folder/run"
