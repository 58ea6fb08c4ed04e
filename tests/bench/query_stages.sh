#!/bin/sh
# SPDX-License-Identifier: Zlib
# Where the instructions of a query go, for each intersecting pair, by callgrind: what one more visit of all poses costs.
# Usage: query_stages.sh BENCH_QUERY FOLDER [MODE=law] [SPHERES=10000] [OVERLAP=0.1] (the folder keeps the bodies)
set -eu
bench=$1 folder=$2 mode=${3:-law} spheres=${4:-10000} overlap=${5:-0.1}
export BULLETHAPTICS_ISA="${BULLETHAPTICS_ISA:-v3}"
counts=$(mktemp)
trap 'rm -f "$counts" "$counts".*' EXIT

run()
{
	"$@" --cache "$folder" --poses 4 --visits "$visits" --only "$mode" --overlap "$overlap" "$spheres"
}
# Lines "visits, instructions, function".
for visits in 1 5; do
	run valgrind --tool=callgrind --callgrind-out-file="$counts.$visits" "$bench" >"$counts.log" 2>&1
	callgrind_annotate --threshold=100 --show-percs=no "$counts.$visits" |
		awk -v v="$visits" '$2 ~ /:/ { gsub(",", "", $1); $1 = v " " $1; print }' >>"$counts"
done
visits=1
pairs=$(run "$bench" | awk 'END { print $4 }')
awk -v pairs="$pairs" -v mode="$mode" -v isa="$BULLETHAPTICS_ISA" '
	function stage(name)
	{
		if (name ~ /pairsOfBalls/) return "balls of A against blocks of B"
		if (name ~ /ballsNearBlocks|drainLeaves|moveBlock/) return "blocks: balls of A near them, turning those of B"
		if (name ~ /search\(/) return "nodes"
		if (name ~ /sift/) return "ellipsoids that are apart"
		if (name ~ /evaluate|refine/) return "law"
		if (name ~ /sum[A-Z]|flushStage|stageLanes/) return "sums"
		if (name ~ /join|Grouper/) return "grouping"
		return "rest"
	}
	{ n[stage($0)] += ($1 == 5 ? $2 : -$2) / (16 * pairs) }
	END {
		printf "%s %s: %.0f pairs\n", mode, isa, pairs
		for (s in n) { total += n[s]; printf "%8.1f %s\n", n[s], s | "sort -rn" }
		close("sort -rn")
		printf "%8.1f together\n", total
	}' "$counts"
