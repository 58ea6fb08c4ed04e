#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Installs what is missing, builds in Release, and runs tests.
# Usage: ./test.sh [--all [--within=SECONDS] | --windows | --arm] [--yes]
#   without --all: the libraries in single precision and their quick tests; some ten minutes on two cores without a compiler cache
#   --all: everything that CI runs: both precisions, demos, consumers, each header by itself, the sanitizers, and quick tests for Windows
#     under Wine and for 64-bit ARM under QEMU; the tests labelled "long" stay out
#   --within: leaves out, and says so, a sanitizer or a system that might not end in that time, as without a compiler cache
#   --windows: the libraries, commands and tests for Windows, built by mingw-w64 and run under Wine, and a zip with DLLs, used from where it
#     was unpacked; an hour or two on two cores
#   --arm: the libraries, commands and tests for 64-bit ARM, run under QEMU; an hour or more on two cores
set -euo pipefail
cd "$(dirname "$0")"

which=quick options=() within=
for argument in "$@"; do
	case $argument in
	--all | --windows | --arm) which=${argument#--} ;;
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
arm() { bash tests/compilers/arm64.sh "$@" "$PWD" "$PWD/build/release/arm64" "$PWD/build/release/tests/unit"; }
# part NAME: a sanitizer, or quick tests for another system. What those systems need is a package or a download that may be out of reach.
part()
{
	case $1 in
	windows-quick | arm)
		${within:+timeout 400} bash cmake/setup.sh "$1" "${options[@]}" || {
			echo "Left out: $1, because what it needs could not be installed"
			return 0
		}
		;;
	esac
	if [ "$1" = arm ]; then arm --quick; else run "$1"; fi
}
case $which in
all)
	run release
	# Seconds that each takes on two cores without a compiler cache. A system may wait for packages, and for a test that hangs.
	for row in asan:2300 tsan:1100 windows-quick:1700 arm:1000; do
		if [ -n "$within" ] && [ $((SECONDS + ${row#*:})) -gt "$within" ]; then
			echo "Left out after $SECONDS s: ${row%:*}, which may take ${row#*:} s"
		else
			part ${row%:*}
		fi
	done
	;;
windows)
	run windows-mingw
	cmake -DSOURCE="$PWD" -DWORK="$PWD/build/windows-zip" -DLAUNCHER="$(command -v ccache || true)" \
		-P tests/consumer/windows_zip/RunWindowsZip.cmake
	;;
arm)
	bash cmake/setup.sh arm "${options[@]}"
	cmake --preset release
	cmake --build --preset release --target query_hashes test_core test_core_threads test_devices test_collision
	arm
	;;
quick)
	run quick
	echo "These were the quick tests. Run the rest with ./test.sh --all (more than an hour on two cores)." \
		"CONTRIBUTING.md says how to run one file."
	;;
esac
