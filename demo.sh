#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Installs what is missing, builds, and runs the bunny demo.
# Usage: ./demo.sh [--yes] [--mesh FILE] [other options of haptic_demos]
set -euo pipefail
cd "$(dirname "$0")"

yes=
if [ "${1:-}" = "--yes" ]; then yes=--yes; shift; fi
bash cmake/setup.sh demos $yes
cmake --preset release >build-log.txt 2>&1 || { cat build-log.txt >&2; exit 1; }
# On a terminal with the steps that ninja counts.
build()
{
	cmake --build --preset release --target haptic_demos ist devicebridge_command \
		devicebridge_dhd devicebridge_hd devicebridge_virtuose 2>&1 | tee -a build-log.txt | while read -r step _; do
		if [[ -t 2 && $step == \[*\] ]]; then printf '%s\r' "$step" >&2; fi
	done
}
echo "Building, for minutes the first time (build-log.txt has the details) ..." >&2
build || { cat build-log.txt >&2; exit 1; }
exec build/release/demos/haptic_demos --demo haptic-bunny --headless --report bunny-report.html "$@"
