#!/bin/sh
# SPDX-License-Identifier: Zlib
# Instructions and simulated mispredicts of a query for each intersecting pair, by cachegrind: what one more visit of all poses costs.
# Usage: query_instructions.sh BENCH_QUERY FOLDER [SPHERES=10000] [OVERLAP=0.1] (the folder keeps the bodies)
set -eu
bench=$1 folder=$2 spheres=${3:-10000} overlap=${4:-0.1}
mkdir -p "$folder"
export BULLETHAPTICS_ISA="${BULLETHAPTICS_ISA:-v3}"

counts()
{
	valgrind --tool=cachegrind --cache-sim=no --branch-sim=yes --cachegrind-out-file=/dev/null \
		"$bench" --cache "$folder" --poses 4 --visits "$2" --only "$1" --overlap "$overlap" "$spheres" 2>&1 |
		awk '/I +refs:/ { gsub(",", "", $NF); i = $NF } /Mispredicts:/ { gsub(",", "", $3); m = $3 } END { print i, m }'
}
for mode in naive paper law law+K law+K+patches; do
	pairs=$("$bench" --cache "$folder" --poses 4 --visits 1 --only "$mode" --overlap "$overlap" "$spheres" | awk 'END { print $4 }')
	set -- $(counts "$mode" 1) $(counts "$mode" 5)
	awk -v mode="$mode" -v pairs="$pairs" -v i1="$1" -v m1="$2" -v i5="$3" -v m5="$4" -v isa="$BULLETHAPTICS_ISA" \
		'BEGIN {
			n = 4 * 4 * pairs
			printf "%-13s %s: %.0f pairs, %.0f instructions and %.2f mispredicts a pair\n", mode, isa, pairs, (i5 - i1) / n, (m5 - m1) / n
		}'
done
