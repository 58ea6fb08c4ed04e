#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Runs every demo of the browser for a moment, without a window and with small trees, for builds with sanitizers.
# Any exit code but 0 fails. No demo is over so soon, so none judges its own numbers.
# Usage: every_demo_test.sh PATH_TO_HAPTIC_DEMOS FOLDER_FOR_TREES [NAME...]
set -u
demos=$1 folder=$2
shift 2
mkdir -p "$folder"
[ $# -gt 0 ] && names=("$@") || mapfile -t names < <("$demos" --list | sed '1,/^of the browser/d; s/ .*//')
failures=0
for name in "${names[@]}"; do
	begun=$SECONDS
	"$demos" --demo "$name" --headless --frames 30 --spheres 500 --cache "$folder" >"$folder/out" 2>"$folder/err"
	code=$?
	if [ $code -ne 0 ] || grep -qE 'Sanitizer|runtime error' "$folder/err"; then
		echo "FAILED $name: exit $code"
		cat "$folder/err"
		failures=$((failures + 1))
	else
		echo "$name: $((SECONDS - begun)) s"
	fi
done
[ ${#names[@]} -gt 10 ] || [ $# -gt 0 ] || failures=1
[ $failures -eq 0 ]
