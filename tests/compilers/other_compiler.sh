#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds the libraries with a compiler of one's choice, with warnings as errors, and installs them.
# A program as a user would write it uses them from there. Then the tests of the core run, and in single precision those of the collision
# algorithm and the solver. OpenMP stays out, because it is a package of its own for clang. (same_assets_test.py builds the command.)
# Usage: tests/compilers/other_compiler.sh [--libraries] SOURCE FOLDER COMPILER [CMAKE_OPTION]...
#   --libraries    no tests after the program
#   CMAKE_OPTION   for the libraries and the program, e.g. -DCMAKE_CXX_STANDARD=23
# Exit status 77: the compiler is missing, with the line that installs it.
set -euo pipefail
libraries=
if [ "$1" = --libraries ]; then
	libraries=1
	shift
fi
source=$1 folder=$2 compiler=$3 options=("${@:4}")

command -v "$compiler" >/dev/null || {
	echo "skipped: no $compiler (apt-get install ${compiler/clang++/clang})"
	exit 77
}
"$compiler" --version | head -n 1

configure()
{
	cmake -S "$1" -B "$2" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$compiler" "${options[@]}" "${@:3}" >/dev/null
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
[ -z "$libraries" ] || exit 0

configure "$source" "$build" -DBULLETHAPTICS_TESTS=ON
programs=(test_core test_collision test_force)
cmake --build "$build" --target "${programs[@]}"
status=0
for program in "${programs[@]}"; do
	echo "$program:"
	(cd "$build/tests/unit" && ./$program --gtest_brief=1) || status=1
done
exit $status
