#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# May programs that were built against an earlier version run with this one, without being built anew?
# Usage: packaging/abi_check.sh REVISION             builds the libraries of that revision and of the working tree, and compares
#        packaging/abi_check.sh --release            the same with the last release: the highest of the tags v*,
#                                                    else the commit that set the version
#        packaging/abi_check.sh --installed OLD NEW  compares two install prefixes whose libraries hold debug information
# Exit status: 0 yes, or the soname changed and says no by itself; 1 no; 77 abidiff is not there (apt-get install abigail-tools),
# or there is no release yet.
set -euo pipefail

command -v abidiff >/dev/null || { echo "skipped: no abidiff (apt-get install abigail-tools)" >&2; exit 77; }

compare() {
	local old new status=0 kind compared=0
	while IFS= read -r old; do
		new=$(find "$2" -name "$(basename "$old")" | head -n 1)
		if [ -z "$new" ]; then
			echo "$(basename "$old"): gone; programs that want this soname go on with the old library"
			continue
		fi
		compared=$((compared + 1))
		kind=0
		abidiff --drop-private-types --headers-dir1 "$1/include" --headers-dir2 "$2/include" "$old" "$new" || kind=$?
		# Of abidiff's bits the first two say that it could not compare, the others that the interface changed; what was only added does no harm.
		if [ $((kind & 3)) -ne 0 ]; then
			echo "$(basename "$old"): could not be compared" >&2
			status=1
		elif [ $((kind & 8)) -ne 0 ] || { [ $((kind & 4)) -ne 0 ] && ! onlyAdded "$1" "$2" "$old" "$new"; }; then
			echo "$(basename "$old"): programs must be built anew, so the soname must change" >&2
			status=1
		fi
	done < <(find "$1" -name 'lib*.so.*' -type l)
	[ "$compared" -gt 0 ] || echo "no library of the same soname"
	return $status
}

onlyAdded() { abidiff --no-added-syms --drop-private-types --headers-dir1 "$1/include" --headers-dir2 "$2/include" "$3" "$4" >/dev/null; }

install_tree() { # SOURCE PREFIX
	cmake -S "$1" -B "$2.build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS=-g -DBUILD_SHARED_LIBS=ON -DBULLETHAPTICS_TESTS=OFF \
		-DBULLETHAPTICS_TOOLS=OFF -DBULLETHAPTICS_DEMOS=OFF -DBULLETHAPTICS_PYTHON=OFF -DBULLETHAPTICS_PRELOAD=OFF \
		-DCMAKE_INSTALL_PREFIX="$2" >/dev/null
	cmake --build "$2.build" --target install >/dev/null
}

source=$(cd "$(dirname "$0")/.." && pwd)
if [ "${1:-}" = --release ] && [ $# -eq 1 ]; then
	tag=$(git -C "$source" for-each-ref --count=1 --sort=-version:refname --format='%(refname:short)' 'refs/tags/v[0-9]*' 2>/dev/null) || true
	[ -n "$tag" ] || tag=$(git -C "$source" log -1 --format=%H -G'^project\(BulletHaptics VERSION ' -- CMakeLists.txt 2>/dev/null) || true
	[ -n "$tag" ] || { echo "skipped: no release yet: there is no tag v*, and no commit that set a version" >&2; exit 77; }
	echo "against $tag"
	set -- "$tag"
fi
if [ "${1:-}" = --installed ] && [ $# -eq 3 ]; then
	compare "$2" "$3"
elif [ $# -eq 1 ] && [ "${1:0:1}" != - ]; then
	work=$(mktemp -d)
	trap 'rm -rf "$work"' EXIT
	mkdir "$work/source"
	git -C "$source" archive "$1" | tar -x -C "$work/source"
	install_tree "$work/source" "$work/old"
	install_tree "$source" "$work/new"
	compare "$work/old" "$work/new"
else
	sed -n '3,9s/^# //p' "$0" >&2
	exit 2
fi
