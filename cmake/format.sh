#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Formats all C++ sources as .clang-format says, with clang-format 14: other versions break lines elsewhere.
# Usage: cmake/format.sh [--check]
#   --check   changes nothing; says which files differ, and which lines of any source or script are longer than 140 characters
set -euo pipefail
cd "$(dirname "$0")/.."

format=$(command -v clang-format-14 || command -v clang-format || true)
if [ -z "$format" ] || ! "$format" --version | grep -q 'version 14\.'; then
	echo "format.sh: clang-format 14 is missing (apt-get install clang-format-14)" >&2
	exit 77
fi
if ! git rev-parse --git-dir >/dev/null 2>&1; then
	echo "format.sh: this is no clone, and so there is no list of sources" >&2
	exit 77
fi
list=$(mktemp)
trap 'rm -f "$list"' EXIT
# tracked PATTERN...: the files of the clone that exist, each ended by a zero byte.
tracked() { git ls-files -z "$@" | while IFS= read -r -d '' file; do [ ! -e "$file" ] || printf '%s\0' "$file"; done; }
tracked '*.h' '*.cpp' >"$list"
if [ "${1:-}" != --check ]; then
	xargs -0 "$format" -i <"$list"
	exit
fi
status=0
xargs -0 "$format" --dry-run --Werror --ferror-limit=1 <"$list" || status=1
# clang-format knows no scripts: their lines are broken by hand.
tracked '*.py' '*.sh' '*.cmake' '*CMakeLists.txt' '*.in' .ci/run >>"$list"
long=$(xargs -0 awk 'length > 140 { print FILENAME ":" FNR ": " length " characters, more than 140" }' <"$list")
if [ -n "$long" ]; then
	echo "$long" >&2
	status=1
fi
[ $status -eq 0 ] || echo "format.sh: run cmake/format.sh" >&2
exit $status
