#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# The real window under a virtual X server. Usage: window_test.sh PATH_TO_HAPTIC_DEMOS
set -u
demos=$1
command -v xvfb-run >/dev/null || { echo "skipped: apt-get install xvfb xauth"; exit 77; }
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
failures=0
fail() { echo "FAILED: $1"; cat "$dir/err"; failures=$((failures + 1)); }

xvfb-run -a "$demos" --cache "$dir" --spheres 200 --demo stack --frames 4 --size 640x360 --window-screenshot "$dir/window.png" >"$dir/out" 2>"$dir/err" || fail "the window opens and closes itself"
head -c 8 "$dir/window.png" 2>/dev/null | grep -q PNG || fail "it leaves a picture"
[ ! -s "$dir/out" ] || fail "a window prints nothing to stdout"

env -u DISPLAY -u WAYLAND_DISPLAY "$demos" --cache "$dir" >"$dir/out" 2>"$dir/err"
[ $? -eq 1 ] && grep -q "without a display, give --headless" "$dir/err" || fail "no display is said in a sentence"
exit $((failures > 0))
