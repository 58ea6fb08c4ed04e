#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Every fuzzer of a build by clang (see CMakeLists.txt) for so many seconds each, one after the other; what it finds stays in FOLDER/NAME.
# Usage: run_all.sh BUILD SECONDS FOLDER [NAME...]       an hour each: run_all.sh build/fuzz 3600 build/found
set -u
build=$1 seconds=$2 folder=$3
shift 3
source=$(cd "$(dirname "$0")/../.." && pwd)
names=("$@")
[ ${#names[@]} -gt 0 ] || for program in "$build"/tests/fuzz/fuzz_*; do
	[ -x "$program" ] && [ -f "$program" ] && names+=("${program##*/fuzz_}")
done
[ ${#names[@]} -gt 0 ] || { echo "no fuzzers in $build/tests/fuzz: build them first"; exit 1; }
for name in "${names[@]}"; do
	"$build/tests/fuzz/fuzz_$name" -help=1 2>&1 </dev/null | grep -q max_total_time || {
		echo "$build/tests/fuzz/fuzz_$name is not there, or has no libFuzzer: configure with clang (CONTRIBUTING.md)"
		exit 1
	}
done
status=0
for name in "${names[@]}"; do
	corpus=$folder/$name/corpus
	mkdir -p "$corpus"
	seeds=()
	case $name in
		asset_loader) seeds=("$source/data/golden") ;;
		scene_file) seeds=("$source/data/scenes") ;;
		study_file) seeds=("$source/data/studies") ;;
		simulated_profile) seeds=("$source/data/devices") ;;
	esac
	[ -d "$source/tests/fuzz/seeds/$name" ] && seeds+=("$source/tests/fuzz/seeds/$name")
	# assimp leaks what it holds when it gives a file up.
	leaks=1
	[ "$name" = mesh_file ] && leaks=0
	ASAN_OPTIONS=detect_leaks=$leaks "$build/tests/fuzz/fuzz_$name" -max_total_time="$seconds" -max_len=65536 -timeout=300 \
		-rss_limit_mb=4096 -print_final_stats=1 \
		-artifact_prefix="$folder/$name/" "$corpus" "${seeds[@]}" >"$folder/$name/log" 2>&1
	code=$?
	[ $code -eq 0 ] || status=1
	inputs=$(grep -o 'number_of_executed_units: *[0-9]*' "$folder/$name/log" | grep -o '[0-9]*$')
	echo "$name: exit $code, $inputs inputs in $seconds s, $(ls "$corpus" | wc -l) kept"
done
exit $status
