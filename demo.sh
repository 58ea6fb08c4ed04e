#!/usr/bin/env bash
# Installs what is missing, builds, and runs the bunny demo.
# Usage: ./demo.sh [--yes] [--mesh FILE] [other options of haptic_demos]
set -euo pipefail
cd "$(dirname "$0")"

yes=
if [ "${1:-}" = "--yes" ]; then yes=--yes; shift; fi
bash cmake/setup.sh demos $yes
cmake --preset release >build-log.txt 2>&1 || { cat build-log.txt >&2; exit 1; }
echo "Building (build-log.txt has the details) ..." >&2
cmake --build --preset release --target haptic_demos ist >>build-log.txt 2>&1 || { cat build-log.txt >&2; exit 1; }
exec build/release/demos/haptic_demos --demo haptic-bunny --headless --report bunny-report.html "$@"
