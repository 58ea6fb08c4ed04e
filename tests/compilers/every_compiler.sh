#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds the libraries with each compiler that Debian 12 has, in C++20 and in C++23, and uses them from a program (other_compiler.sh).
# With --tests it also runs, in C++20, the tests of core, collision and solver. Prints a line for each and goes on after a failure.
# Usage: tests/compilers/every_compiler.sh [--tests] SOURCE FOLDER [COMPILER]...
#   COMPILER   some of g++-11 g++-12 clang++-14 clang++-16 clang++-19; without any, all of them
# What a build says is in FOLDER/COMPILER-STANDARD.log. A build takes some ten minutes of processor time.
# Exit status 77: compilers are missing, and all others are well.
set -euo pipefail
tests=
if [ "${1-}" = --tests ]; then
	tests=1
	shift
fi
source=$1 folder=$2
shift 2
[ $# -gt 0 ] || set -- g++-11 g++-12 clang++-14 clang++-16 clang++-19
mkdir -p "$folder"

status=0
for compiler in "$@"; do
	for standard in 20 23; do
		name=$compiler-$standard
		how=(--libraries)
		if [ -n "$tests" ] && [ $standard = 20 ]; then how=(); fi
		code=0
		bash "$(dirname "$0")/other_compiler.sh" "${how[@]}" "$source" "$folder/$name" "$compiler" -DCMAKE_CXX_STANDARD=$standard \
			>"$folder/$name.log" 2>&1 || code=$?
		case $code in
		0) echo "$compiler, C++$standard: ok" ;;
		77)
			tail -n 1 "$folder/$name.log"
			[ $status -ne 0 ] || status=77
			break
			;;
		*)
			echo "$compiler, C++$standard: FAILED, see $folder/$name.log"
			status=1
			;;
		esac
		rm -rf "${folder:?}/$name/build"
	done
done
exit $status
