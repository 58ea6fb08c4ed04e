#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds the libraries in single precision with -fno-rtti, uses them from a program that is built so, too, and runs their tests
# (other_compiler.sh). No library may need the type information of one of Bullet's classes, which a Bullet without RTTI does not have.
# Usage: tests/compilers/without_rtti.sh [--libraries] SOURCE FOLDER COMPILER
set -euo pipefail
how=()
if [ "$1" = --libraries ]; then
	how=("$1")
	shift
fi
source=$1 folder=$2 compiler=$3
bash "$(dirname "$0")/other_compiler.sh" "${how[@]}" "$source" "$folder" "$compiler" \
	-DCMAKE_CXX_FLAGS=-fno-rtti -DBULLETHAPTICS_PRECISIONS=Single
mapfile -t libraries < <(find "$folder/prefix" -name '*.a')
[ ${#libraries[@]} -gt 0 ] || { echo "no libraries in $folder/prefix" >&2; exit 1; }
if nm -A -C "${libraries[@]}" | grep ' U typeinfo for bt'; then
	echo "these need Bullet's type information" >&2
	exit 1
fi
