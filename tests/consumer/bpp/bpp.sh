#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# A game by other authors, bullet-physics-playground (github.com/bullet-physics-playground/bpp, 2efed9c; LGPL), as it is and with our lines.
# Are its scenes the same, bit for bit, while nothing is attached, is it as stable with trees, and what do its frames cost?
# Usage: bpp.sh STOCK OURS FOLDER [SCENE...]
# STOCK and OURS are two folders in which the game was built, as build.sh does.
# OURS has Volumetric.h, is linked with Volumetric.cpp and bullethaptics-force, and has four lines more:
#   viewer.h     after `btDiscreteDynamicsWorld *dynamicsWorld;`                     std::shared_ptr<Volumetric> volumetric;
#   viewer.cpp   after `btGImpactCollisionAlgorithm::registerAlgorithm(dispatcher);` volumetric = makeVolumetric(*dynamicsWorld);
#   viewer.cpp   before `delete dynamicsWorld;`                                      volumetric.reset();
#   viewer.cpp   before `dynamicsWorld->stepSimulation(`                             updateVolumetric(volumetric.get());
# Some scenes want more than our lines (`wants` below). Each of them is run without that, too, and both rows count in the last two lines.
# The script fails where a scene is not the same, or where it is wilder with what it wants.
# The scene 02-trimesh with our lines alone takes a quarter of an hour.
# It needs: libbullet-dev pkg-config
set -euo pipefail
[ $# -ge 3 ] || { sed -n 5,11p "$0"; exit 2; }
here=$(cd "$(dirname "$0")" && pwd) stock=$(realpath "$1") ours=$(realpath "$2")
mkdir -p "$3"
folder=$(cd "$3" && pwd)
shift 3
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(jaimevives/mesh-chain basic/02-mesh basic/02-trimesh basic/04-domino constraint/01-car
	koppi/gravity-box jaimevives/mesh-chain2)
export QT_QPA_PLATFORM=offscreen XDG_CONFIG_HOME=$folder/settings XDG_CACHE_HOME=$folder/cache
g++ -O2 -shared -fPIC $(pkg-config --cflags bullet) "$here/trace.cpp" -o "$folder/trace.so" $(pkg-config --libs bullet) -ldl

# What a scene wants of our lines (Volumetric.h): a second row with trees, which counts.
declare -A wants=(
	[jaimevives/mesh-chain]="BPP_STIFFNESS=10000"
	[jaimevives/mesh-chain2]="BPP_STIFFNESS=10000"
	[basic/02-trimesh]="BPP_PAIR_BUDGET=500 BPP_KEPT_ERROR=.05"
)

# frames WORDS BUILD SCENE TRACE [SETTING...]: prints mean and median of a frame behind these words, and below how wild the scene was.
# A game that ends before it has told them fails.
frames()
{
	local words=$1 build=$2 scene=$3 trace=$4
	shift 4
	told='' mean=0
	rm -f "$folder/$trace"
	(cd "$build" && env "$@" LD_PRELOAD="$folder/trace.so" TRACE="$folder/$trace" release/bpp -n 100 -f "demo/$scene.lua") \
		>/dev/null 2>"$folder/log.txt" || true
	told=$(grep '^fastest' "$folder/log.txt") || { echo "  $words no frame was told: see $folder/log.txt"; status=1; return; }
	echo "  $words $(grep '^frames' "$folder/log.txt" | sed 's/.*mean/mean/')"
	mean=$(sed -n 's/^frames.*mean \([0-9.]*\) ms.*/\1/p' "$folder/log.txt")
	[[ $scene == *chain* ]] && echo "$indent$told" || echo "$indent$(sed 's/neighbours.*apart; //' <<<"$told")"
}

# with_trees WORDS SCENE [SETTING...]: prints a row with trees, and whether the scene is no wilder than it was as it is.
# No body may be faster by more than half and 0.5 m/s, neither ever nor in the last second.
# No link of a chain may be farther from its neighbour by more than a fifth.
# The variable `worse` says how the scene is not as it was, or is empty.
with_trees()
{
	local words=$1 scene=$2 wilder=1
	shift 2
	worse=wilder
	frames "$words" "$ours" "$scene" trees.txt "$@"
	if grep -qsE 'nan|inf' "$folder/trees.txt"; then echo "${indent}poses that are no numbers"; return; fi
	printf '%s\n' "$as_it_is" "$told" | awk -v "chain=$([[ $scene != *chain* ]] || echo 1)" '
		NR == 1 { fastest = $2; last = $8; apart = $11 }
		NR == 2 { exit !($2 <= 1.5 * fastest + .5 && $8 <= 1.5 * last + .5 && (!chain || $11 <= 1.2 * apart)) }' && wilder=0
	((!wilder)) && echo "${indent}no wilder than as it is" || echo "${indent}WILDER than as it is"
	((wilder)) || worse=
	if awk "BEGIN { exit !($mean > 10 * $mean_as_it_is) }"; then
		echo "${indent}MORE THAN TEN TIMES AS SLOW"
		worse+=${worse:+ and }slow
	fi
}

status=0 indent="                               "
alone=() wanted=()  # the scenes that are worse
for scene in "${scenes[@]}"; do
	echo "$scene"
	frames "as it is:                   " "$stock" "$scene" stock.txt
	as_it_is=$told mean_as_it_is=$mean
	frames "our lines, nothing attached:" "$ours" "$scene" idle.txt BPP_VOLUMETRIC=idle
	cmp "$folder/stock.txt" "$folder/idle.txt" && echo "${indent}the same, bit for bit: $(wc -l <"$folder/stock.txt") poses" || status=1
	with_trees "trees for GImpact's meshes: " "$scene"
	[ -z "$worse" ] || alone+=("$scene ($worse)")
	read -ra settings <<<"${wants[$scene]:-}"
	[ ${#settings[@]} -eq 0 ] || with_trees "${settings[*]}:" "$scene" "${settings[@]}"
	[ -z "$worse" ] || wanted+=("$scene ($worse)")
	[[ $worse != wilder* ]] || status=1
done
# tell WORDS SCENE...: how many, and which.
tell()
{
	local words=$1 list
	shift
	list=$(printf ', %s' "$@")
	echo "$words: worse in $# of ${#scenes[@]} scenes${1:+: ${list:2}}"
}
tell "our lines alone" "${alone[@]}"
tell "with what each wants" "${wanted[@]}"
exit $status
