#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# The real window under a virtual X server, and what is said where there is none.
# Usage: window_test.sh PATH_TO_HAPTIC_DEMOS PATH_TO_TEST_BROWSER_VIEW
set -u
demos=$1
tests=$2
command -v Xvfb >/dev/null || { echo "skipped: apt-get install xvfb"; exit 77; }
dir=$(mktemp -d)
# One server for all: without -noreset it would begin anew, and answer nobody meanwhile, whenever its last window is closed.
Xvfb -displayfd 3 -noreset -nolisten tcp -screen 0 1280x1024x24 3>"$dir/display" 2>/dev/null &
trap 'kill %1; rm -rf "$dir"' EXIT
for _ in $(seq 300); do [ -s "$dir/display" ] && break; sleep 0.1; done
[ -s "$dir/display" ] || { echo "FAILED: the X server starts"; exit 1; }
export DISPLAY=:$(cat "$dir/display")
unset WAYLAND_DISPLAY
failures=0
fail() { echo "FAILED: $1"; cat "$dir/err"; failures=$((failures + 1)); }
few="--cache $dir --spheres 200"

"$demos" $few --demo stack --frames 4 --size 640x360 --window-screenshot "$dir/window.png" >"$dir/out" 2>"$dir/err" ||
	fail "the window opens and closes itself"
head -c 8 "$dir/window.png" 2>/dev/null | grep -q PNG || fail "it leaves a picture"
[ ! -s "$dir/out" ] || fail "a window prints nothing to stdout"
"$demos" $few --demo stack --beside-stock --show levels --frames 3 --size 640x360 --window-screenshot "$dir/halves.png" \
	>"$dir/out" 2>"$dir/err" || fail "two halves open"
cmp -s "$dir/window.png" "$dir/halves.png" && fail "two halves look otherwise"
"$demos" $few --demo hello --frames 5 --size 320x240 --device sim:sigma7 >"$dir/out" 2>"$dir/err" ||
	fail "a window with a device opens and closes itself"
"$tests" --gtest_filter='Window.*' >"$dir/out" 2>"$dir/err" || { cat "$dir/out"; fail "sizes, minimising, a device that is not there"; }
grep -q SKIPPED "$dir/out" && fail "the window's own tests ran"

# says TEXT WHAT CODE COMMAND...
says()
{
	local text=$1 what=$2 code=$3
	shift 3
	"$@" >"$dir/out" 2>"$dir/err"
	local rc=$?
	{ [ $rc -eq "$code" ] && grep -q -- "$text" "$dir/err"; } || { echo "exit code $rc"; fail "$what"; }
}
says "without a display, give --demo NAME and --headless" "no display is said in a sentence" 1 \
	env -u DISPLAY -u WAYLAND_DISPLAY "$demos" --cache "$dir"
says "no window with OpenGL 3.3" "an old OpenGL is said in a sentence" 1 env MESA_GL_VERSION_OVERRIDE=2.1 "$demos" --cache "$dir"
says "no OpenGL 3.3 without a window" "an old OpenGL is said for pictures" 1 \
	env MESA_GL_VERSION_OVERRIDE=2.1 "$demos" $few --demo hello --screenshot "$dir/a.png"
says "nosuchdriver" "a device that is not there is named" 1 "$demos" $few --demo hello --frames 2 --device nosuchdriver:0
says "no demo is called nothing" "a wrong name is said in a sentence" 2 "$demos" --demo nothing
says "/no/such/mesh.obj" "a missing mesh is named" 1 "$demos" $few --demo packing --mesh /no/such/mesh.obj --headless
says "floating has no side of stock Bullet" "a demo without another side says so" 1 "$demos" $few --demo floating --beside-stock --headless
says 'knows no "sphere"' "an unknown choice is named" 1 "$demos" $few --demo hello --show sphere --screenshot "$dir/a.png"
says "force-error must be" "a force error that is none is named" 2 "$demos" --demo hello --force-error 2
[ ! -e "$dir/a.png" ] || fail "what failed leaves no picture"

# A recording begins at the beginning: 0, 1/30 ... 6/30 s, and is not mixed with another one.
"$demos" $few --demo hello --frames 48 --size 64x36 --record "$dir/film" >"$dir/out" 2>"$dir/err" || fail "a demo is recorded"
pictures="00000.png 00001.png 00002.png 00003.png 00004.png 00005.png 00006.png "
[ "$(ls "$dir/film" | tr '\n' ' ')" = "$pictures" ] || { ls "$dir/film"; fail "thirty pictures a second"; }
cmp -s "$dir/film/00000.png" "$dir/film/00006.png" && fail "the pictures of a recording differ"
says "holds a recording already" "recordings are not mixed" 1 "$demos" $few --demo hello --frames 8 --size 64x36 --record "$dir/film"
"$demos" $few --demo hello --frames 2 --dt 0.1 --size 64x36 --record "$dir/slow" >"$dir/out" 2>"$dir/err" || fail "long steps are recorded"
[ "$(ls "$dir/slow" | wc -l)" -eq 7 ] || { ls "$dir/slow"; fail "long steps leave thirty pictures a second, too"; }
exit $((failures > 0))
