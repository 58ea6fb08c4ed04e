#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Installs what is missing, builds in Release, and runs tests.
# Usage: ./test.sh [--all] [--yes]
#   without --all: the libraries in single precision and their quick tests; twelve minutes on two cores without a compiler cache
#   --all: everything that CI runs: both precisions, demos, consumers, each header by itself, and the sanitizers; not the tests labelled "long"
set -euo pipefail
cd "$(dirname "$0")"

all='' options=()
for argument in "$@"; do
	if [ "$argument" = --all ]; then all=1; else options+=("$argument"); fi
done

bash cmake/setup.sh tests "${options[@]}"
presets=(quick)
[ -z "$all" ] || presets=(release asan tsan)
for preset in "${presets[@]}"; do
	cmake --preset "$preset"
	cmake --build --preset "$preset"
	ctest --preset "$preset"
done
[ -n "$all" ] || echo "These were the quick tests. The rest: ./test.sh --all (an hour on two cores); one test file: see CONTRIBUTING.md"
