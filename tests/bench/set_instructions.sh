#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Instructions of a query for each intersecting pair, or for each face where surfaces answer: what one more visit of all poses costs.
# On x86-64 cachegrind counts them; for 64-bit ARM a plug-in of QEMU's does, with the program of that architecture.
# Usage: set_instructions.sh BENCH_SETS TREE OVERLAP SET [SYSROOT]
#   SYSROOT: libraries for BENCH_SETS, if it is built for 64-bit ARM; tests/compilers/arm64.sh unpacks them
set -euo pipefail
bench=$1 tree=$2 overlap=$3 set=$4 sysroot=${5:-}
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
[ -z "$sysroot" ] || gcc -shared -fPIC -O2 "$(dirname "$0")/qemu_instructions.c" -o "$work/plugin.so"

run() { "$@" "$bench" --poses 2 --visits "$visits" --only "$mode" --set "$set" "$tree" "$overlap"; }
count()
{
	visits=$1
	if [ -n "$sysroot" ]; then run qemu-aarch64 -plugin "$work/plugin.so" -L "$sysroot"
	else run valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null
	fi >"$work/table" 2>"$work/log"
	awk '/instructions:|I +refs:/ { gsub(",", "", $NF); print $NF }' "$work/log"
}
for mode in surface paper law law+K+patches; do
	one=$(count 1)
	three=$(count 3)
	awk -v mode="$mode" -v set="$set" -v more=$((three - one)) \
		'END { printf "%-14s %-9s %.0f pairs, %.0f instructions a pair\n", mode, set, $4, more / (4 * $4) }' "$work/table"
done
