#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# A game that nobody here wrote, bullet-physics-playground (github.com/bullet-physics-playground/bpp, 2efed9c; LGPL), as it is and with our lines: are its scenes the same,
# bit for bit, while nothing is attached, and what do its frames cost?
# Usage: bpp.sh STOCK OURS FOLDER [SCENE...]
# STOCK and OURS are two folders in which the game was built. OURS has Volumetric.h, is linked with Volumetric.cpp and bullethaptics-force, and has four lines more:
#   viewer.h     after `btDiscreteDynamicsWorld *dynamicsWorld;`                     std::shared_ptr<Volumetric> volumetric;
#   viewer.cpp   after `btGImpactCollisionAlgorithm::registerAlgorithm(dispatcher);` volumetric = makeVolumetric(*dynamicsWorld);
#   viewer.cpp   before `delete dynamicsWorld;`                                      volumetric.reset();
#   viewer.cpp   before `dynamicsWorld->stepSimulation(`                             updateVolumetric(volumetric.get());
# It needs: libbullet-dev pkg-config
set -euo pipefail
[ $# -ge 3 ] || { sed -n 5,10p "$0"; exit 2; }
here=$(cd "$(dirname "$0")" && pwd) stock=$(realpath "$1") ours=$(realpath "$2")
mkdir -p "$3"
folder=$(cd "$3" && pwd)
shift 3
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(jaimevives/mesh-chain basic/02-mesh basic/04-domino constraint/01-car koppi/gravity-box jaimevives/mesh-chain2)
export QT_QPA_PLATFORM=offscreen XDG_CONFIG_HOME=$folder/settings XDG_CACHE_HOME=$folder/cache
g++ -O2 -shared -fPIC $(pkg-config --cflags bullet) "$here/trace.cpp" -o "$folder/trace.so" $(pkg-config --libs bullet) -ldl

# frames WORDS BUILD SCENE TRACE: mean and median of a frame, behind these words. A game that ends before it has told them fails.
frames()
{
	rm -f "$folder/$4"
	local told
	told=$( (cd "$2" && env LD_PRELOAD="$folder/trace.so" TRACE="$folder/$4" release/bpp -n 100 -f "demo/$3.lua") 2>&1 >/dev/null | grep '^frames' | sed 's/.*mean/mean/') || true
	echo "  $1 ${told:-no frame was told}"
	[ -n "$told" ] || status=1
}
status=0
for scene in "${scenes[@]}"; do
	echo "$scene"
	frames "as it is:                   " "$stock" "$scene" stock.txt
	BPP_VOLUMETRIC=idle frames "our lines, nothing attached:" "$ours" "$scene" idle.txt
	cmp "$folder/stock.txt" "$folder/idle.txt" && echo "                               the same, bit for bit: $(wc -l <"$folder/stock.txt") poses" || status=1
	frames "trees for GImpact's meshes: " "$ours" "$scene" trees.txt
	! grep -qs nan "$folder/trees.txt" || status=1
done
exit $status
