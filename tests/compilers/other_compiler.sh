#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds the libraries with the other of g++ and clang++, with warnings as errors, and installs them.
# A program as a user would write it uses them from there. Then the tests of the core run, and in single precision those of the collision
# algorithm and the solver. OpenMP stays out, because it is a package of its own for clang. (same_assets_test.py builds the command.)
# Usage: tests/compilers/other_compiler.sh SOURCE FOLDER THIS_COMPILER_ID
# Exit status 77: the other compiler is missing, with the line that installs it.
set -euo pipefail
source=$1 folder=$2

other=clang++ package=clang
[ "$3" = GNU ] || other=g++ package=g++
command -v $other >/dev/null || {
	echo "skipped: no $other (apt-get install $package)"
	exit 77
}
$other --version | head -n 1

configure()
{
	cmake -S "$1" -B "$2" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=$other "${@:3}" >/dev/null
}

rm -rf "$folder"
build=$folder/build
configure "$source" "$build" -DBULLETHAPTICS_OPENMP=OFF -DBULLETHAPTICS_DEMOS=OFF -DBULLETHAPTICS_PYTHON=OFF \
	-DBULLETHAPTICS_PRELOAD=OFF -DBULLETHAPTICS_TOOLS=OFF -DBULLETHAPTICS_TESTS=OFF
cmake --build "$build"
cmake --install "$build" --prefix "$folder/prefix" >/dev/null
configure "$source/tests/consumer/find_package" "$folder/consumer" -DCMAKE_PREFIX_PATH="$folder/prefix"
cmake --build "$folder/consumer"
ctest --test-dir "$folder/consumer" --output-on-failure --no-tests=error

configure "$source" "$build" -DBULLETHAPTICS_TESTS=ON
programs=(test_core test_collision test_force)
cmake --build "$build" --target "${programs[@]}"
status=0
for program in "${programs[@]}"; do
	echo "$program:"
	(cd "$build/tests/unit" && ./$program --gtest_brief=1) || status=1
done
exit $status
