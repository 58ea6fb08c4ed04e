#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Installs what is missing, builds in Release, and runs tests.
# Usage: ./test.sh [--all] [--yes]
#   without --all: the libraries in single precision and their quick tests; some ten minutes on two cores without a compiler cache
#   --all: everything that CI runs: both precisions, demos, consumers, each header by itself, and the sanitizers;
#     the tests labelled "long" stay out
set -euo pipefail
cd "$(dirname "$0")"

all='' options=()
for argument in "$@"; do
	if [ "$argument" = --all ]; then all=1; else options+=("$argument"); fi
done

bash cmake/setup.sh tests "${options[@]}"
run()
{
	cmake --preset "$1"
	cmake --build --preset "$1"
	[ "$1" != release ] || cmake --build --preset "$1" --target headers_alone
	ctest --preset "$1"
}
if [ -n "$all" ]; then
	for preset in release asan tsan; do run $preset; done
else
	run quick
	echo "These were the quick tests. Run the rest with ./test.sh --all (more than an hour on two cores)." \
		"CONTRIBUTING.md says how to run one file."
fi
