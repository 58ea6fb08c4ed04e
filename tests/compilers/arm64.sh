#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds all libraries, both commands and tests for 64-bit ARM, and runs tests under QEMU, which takes twenty times as long.
# It runs the tests of the collision algorithm and the solver, and those that compare queries with brute force.
# Of the other tests of core and devices it runs those that take this machine itself no more than a second.
# Queries must give the bits that they give on this machine: query_hashes with NEON here, and with SSE2 there.
# Tests of devices that keep time with a clock stay out, and so do tests that count page faults or resident memory, which are QEMU's, and
# those that start programs.
# The libraries of that architecture are unpacked from this Debian's own package sources; nothing is installed.
# Usage: tests/compilers/arm64.sh [--quick] SOURCE FOLDER NATIVE
#   --quick: builds Core and the collision algorithm alone, compares the bits of queries, and runs quick tests of the collision algorithm
#   NATIVE: a folder with the same test programs for this machine (BUILD/tests/unit)
# Exit status 77: something is missing, with the line that installs it.
set -euo pipefail
short=
if [ "$1" = --quick ]; then
	short=1
	shift
fi
source=$1 folder=$2 native=$3
root=$folder/root build=$folder/build

for program in mmdebstrap aarch64-linux-gnu-g++ qemu-aarch64; do
	command -v $program >/dev/null || {
		echo "skipped: no $program (apt-get install mmdebstrap g++-aarch64-linux-gnu qemu-user)"
		exit 77
	}
done
. /etc/os-release
sources=()
for file in /etc/apt/sources.list /etc/apt/sources.list.d/debian.sources; do [ -s "$file" ] && sources+=("$file"); done

if [ ! -d "$root" ]; then
	mkdir -p "$folder"
	packages=libc6-dev,libstdc++-12-dev,libbullet-dev,libbullet-extras-dev,libassimp-dev,zlib1g-dev,libeigen3-dev
	packages+=,libgtest-dev,libgmock-dev,nlohmann-json3-dev,libcli11-dev,libpng-dev
	mmdebstrap --quiet --architectures=arm64 --variant=extract --include=$packages "$VERSION_CODENAME" "$root.new" "${sources[@]}"
	# Links and CMake files that name files from the root of the file system.
	find "$root.new" -type l -lname '/*' -printf '%p %l\n' | while read -r link target; do ln -sfn "$root$target" "$link"; done
	sed -i "s#/usr/\(lib\|include\)#$root/usr/\1#g" "$root.new"/usr/lib/aarch64-linux-gnu/cmake/{assimp-*,draco}/*.cmake
	# QEMU looks there first, and a copied /dev/ptmx has no terminals.
	rm -r "$root.new/dev"
	mv "$root.new" "$root"
fi

# What a build says, where it fails.
quiet() { "$@" >"$folder/log.txt" 2>&1 || { cat "$folder/log.txt" >&2; return 1; }; }

quiet cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBULLETHAPTICS_SYSROOT="$root" \
	-DCMAKE_TOOLCHAIN_FILE="$source/cmake/aarch64-linux-gnu.cmake"

# Names of a program's tests that end within a second of processor time each, in a process of their own.
quick()
{
	"$1" --gtest_list_tests | awk '/^[^ ]/ { suite = $1 } /^ / { print suite $1 }' | while read -r name; do
		code=0
		(ulimit -t 1 && OMP_NUM_THREADS=1 exec "$1" --gtest_filter="$name") >/dev/null 2>&1 || code=$?
		[ $code -ge 128 ] || echo "$name"
	done 2>/dev/null
}

status=0
quiet cmake --build "$build" --target query_hashes
golden=$source/data/golden
for trees in "cylinder-v7.ist box-v7.ist" "tetrahedron-v7.ist cylinder-v7.ist"; do
	set -- $trees
	BULLETHAPTICS_ISA=neon qemu-aarch64 -L "$root" "$build/tests/compilers/query_hashes" "$golden/$1" "$golden/$2" >"$folder/neon.txt"
	BULLETHAPTICS_ISA=baseline "$native/../compilers/query_hashes" "$golden/$1" "$golden/$2" | diff - "$folder/neon.txt" && continue
	echo "queries of $1 and $2 differ between NEON and SSE2"
	status=1
done
programs=(test_collision) limit=600
if [ -z "$short" ]; then
	limit=3000
	programs=(test_core test_core_threads test_devices test_collision test_collision-float64 test_force test_force-float64)
	quiet cmake --build "$build" --target ist devicebridge_command DeviceBridge DeviceBridge-float64 \
		BulletHapticsTestSupport BulletHapticsTestSupport-float64
	# What a program starts is run by the system, which knows no QEMU.
	importer=$(echo "$build"/BulletISTCollision/bullethaptics-*/bullethaptics-import)
	printf '#!/bin/sh\nexec qemu-aarch64 -L "%s" "%s" "$@"\n' "$root" "$importer" >"$folder/import.sh"
	chmod +x "$folder/import.sh"
	export BULLETHAPTICS_IMPORT=$folder/import.sh
	qemu-aarch64 -L "$root" "$build/DeviceBridge/Tools/devicebridge" list >/dev/null || status=1
fi
quiet cmake --build "$build" --target "${programs[@]}"

# What a program's tests say, and whether they passed.
test_program()
{
	local program=$1 filter='*'
	case $program in
		test_core*)
			filter="OverlapQuery.AgreesWithBruteForce*:$(quick "$native/$program" | paste -sd:)"
			filter+="-AtomicFile.AMappedPartThatWasPopulated*:ImportApart.*:QueryWorkspace.TakesMemory*"
			;;
		test_collision) [ -z "$short" ] || filter=btISTRegistration.*:btISTShapeField.*:meshOfShape.* ;;
		test_devices) filter="$(quick "$native/$program" | paste -sd:)-Stepping*:Threaded*:AnsweringThread.*:GapBridge.*" ;;
	esac
	echo "$program:"
	cd "$build/tests/unit" && timeout $limit qemu-aarch64 -L "$root" ./$program --gtest_brief=1 --gtest_filter="$filter"
}

# One program a core. A file says how it ended.
for program in "${programs[@]}"; do
	while [ "$(jobs -rp | wc -l)" -ge "$(nproc)" ]; do wait -n || true; done
	(test_program $program >"$folder/$program.txt" 2>&1 && echo passed >>"$folder/$program.txt") &
done
wait
for program in "${programs[@]}"; do
	cat "$folder/$program.txt"
	[ "$(tail -n 1 "$folder/$program.txt")" = passed ] || status=1
done
exit $status
