#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# A racing game by other authors, VDrift (github.com/VDrift/vdrift, 3c8741af; GPL), as it is and with our lines.
# Does it drive the same, bit for bit, while nothing is attached, and what do its frames cost?
# Usage: vdrift.sh STOCK OURS DATA FOLDER
# STOCK and OURS are two builds of the game, by build.sh; DATA is its data with the track zandvoort and the car 360.
# OURS has Volumetric.h, is linked with Volumetric.cpp and bullethaptics-force, and has three lines more:
#   game.h     after `DynamicsWorld dynamics;`           std::shared_ptr<Volumetric> volumetric = makeVolumetric(dynamics);
#   game.cpp   in NewGame, when the cars are loaded      attachVolumetric(*volumetric);
#   game.cpp   in LeaveGame, before `track.Clear();`     detachVolumetric(*volumetric);
# RUNS: how often it races in each way, by turns; 3. It needs: xvfb libgl1-mesa-dri libbullet-dev pkg-config
set -euo pipefail
[ $# -eq 4 ] || { sed -n 5,6p "$0"; exit 2; }
here=$(cd "$(dirname "$0")" && pwd) stock=$(realpath "$1") ours=$(realpath "$2") data=$(cd "$3" && pwd)
mkdir -p "$4"
cd "$4"
[ -d data ] || cp -rs "$data" data
[ -d data/tracks/drums ] || python3 "$here/drums.py" data/tracks/zandvoort data/tracks/drums
g++ -O2 -shared -fPIC $(pkg-config --cflags bullet) "$here/../bpp/trace.cpp" -o trace.so $(pkg-config --libs bullet) -ldl
export HOME=$PWD/home VDRIFT_DATA_DIRECTORY=$PWD/data TRACE_FRAMES OMP_NUM_THREADS=1

# frames WORDS PROGRAM MODE TRACE ARGUMENT...: prints mean and median of a frame, behind these words.
# A game that ends before it has told them fails.
frames()
{
	local words=$1 program=$2 mode=$3 trace=$4 told
	shift 4
	rm -rf home  # what a game that was killed leaves there makes the next one begin with other settings
	mkdir -p home/.vdrift
	cat >home/.vdrift/VDrift.config <<-END
		[ game ]
		track = drums
		car = 360
		car_variant = 360
		track_dynamic = on
		vehicle_damage = off
		[ display ]
		resolution = 320,240
		renderer = gl2/basic.conf
		texture_size = small
		shadows = off
		reflections = 0

	END
	rm -f "$trace"
	xvfb-run -a -s "-screen 0 640x480x24" \
		env VDRIFT_VOLUMETRIC="$mode" LD_PRELOAD="$PWD/trace.so" TRACE="$PWD/$trace" "$program" "$@" >log.txt 2>&1 || true
	told=$(grep '^frames' log.txt) || { echo "  $words no frame was told: see $PWD/log.txt"; status=1; return; }
	echo "  $words $told"
	grep -E 'hulls|stays Bullet|representative' log.txt || true
}
same() { cmp "$1" "$2" && echo "                               the same, bit for bit: $(wc -l <"$1") poses" || status=1; }

status=0
echo "top speed and braking on a plane (-cartest 360)"
TRACE_FRAMES=100000
frames "as it is:                   " "$stock" idle stock.txt -cartest 360
frames "our lines, nothing attached:" "$ours" idle idle.txt -cartest 360
same stock.txt idle.txt
TRACE_FRAMES=1200
for run in $(seq "${RUNS:-3}"); do
	echo "a race on zandvoort, through twelve drums, run $run"
	frames "as it is:                   " "$stock" idle stock.txt -benchmark -nosound
	frames "our lines, nothing attached:" "$ours" idle idle.txt -benchmark -nosound
	same stock.txt idle.txt
	frames "trees for car and drums:    " "$ours" trees trees.txt -benchmark -nosound
	! grep -qs nan trees.txt && grep -q 'two hulls in [1-9]' log.txt || status=1
done
exit $status
