#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Installs what is missing, builds in Release, and runs tests.
# Usage: ./test.sh [--all [--within=SECONDS] | --windows] [--yes]
#   without --all: the libraries in single precision and their quick tests; some ten minutes on two cores without a compiler cache
#   --all: everything that CI runs: both precisions, demos, consumers, each header by itself, and the sanitizers;
#     the tests labelled "long" stay out
#   --within: leaves out, and says so, a sanitizer that might not end in that time, as without a compiler cache
#   --windows: the libraries, commands and tests for Windows, built by mingw-w64 and run under Wine, and a zip with DLLs, used from where it
#     was unpacked; an hour or two on two cores
set -euo pipefail
cd "$(dirname "$0")"

which=quick options=() within=
for argument in "$@"; do
	case $argument in
	--all | --windows) which=${argument#--} ;;
	--within=*) within=${argument#*=} ;;
	*) options+=("$argument") ;;
	esac
done

if [ -n "$within" ] && [ $which != all ]; then
	echo "test.sh: --within goes with --all" >&2
	exit 2
fi

scope=tests
[ $which != windows ] || scope=windows
bash cmake/setup.sh $scope "${options[@]}"
run()
{
	cmake --preset "$1"
	cmake --build --preset "$1"
	[ "$1" != release ] || cmake --build --preset "$1" --target headers_alone
	ctest --preset "$1"
}
if [ $which = all ]; then
	run release
	# Seconds that each takes on two cores without a compiler cache.
	for row in asan:2300 tsan:1100; do
		if [ -n "$within" ] && [ $((SECONDS + ${row#*:})) -gt "$within" ]; then
			echo "Left out after $SECONDS s: the preset ${row%:*}, which may take ${row#*:} s"
		else
			run ${row%:*}
		fi
	done
elif [ $which = windows ]; then
	run windows-mingw
	cmake -DSOURCE="$PWD" -DWORK="$PWD/build/windows-zip" -DLAUNCHER="$(command -v ccache || true)" \
		-P tests/consumer/windows_zip/RunWindowsZip.cmake
else
	run quick
	echo "These were the quick tests. Run the rest with ./test.sh --all (more than an hour on two cores)." \
		"CONTRIBUTING.md says how to run one file."
fi
