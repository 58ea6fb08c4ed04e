#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Usage: haptic_demos_command_test.sh PATH_TO_HAPTIC_DEMOS. Exit code 0 when every expectation holds.
set -u
demos=$1
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
failures=0

# expect NAME WANTED_CODE WORDS_ON_STDERR COMMAND...
expect()
{
	local name=$1 wanted=$2 words=$3
	shift 3
	"$@" > "$dir/out" 2> "$dir/err"
	local code=$?
	if [ "$code" -ne "$wanted" ] || ! grep -qF -- "$words" "$dir/err"; then
		echo "FAILED $name: exit $code, wanted $wanted and '$words'"
		cat "$dir/err"
		failures=$((failures + 1))
	fi
}

cat > "$dir/good.json" <<'JSON'
{
	"schema": 1,
	"duration": 0.2,
	"assets": [{"name": "ball", "shape": "box", "halfExtents": [0.02, 0.02, 0.02], "spheres": 20}],
	"bodies": [{"name": "ball", "asset": "ball"}],
	"hand": {"device": "sim:sigma7", "tool": "ball"}
}
JSON
sed 's/"tool": "ball"/"tool": "bell"/' "$dir/good.json" > "$dir/bad.json"

expect "a good scene runs" 0 "" "$demos" --scene "$dir/good.json" --virtual-time --cache "" --json
python3 -c "
import json, sys
r = json.load(open('$dir/out'))
assert r['schema'] == 1 and r['ok'] is True and r['ticks'] == 200 and r['rate_hz'] is None, r
" || failures=$((failures + 1))
expect "a good scene runs at its own pace" 0 "report: $dir/r.html" "$demos" --scene "$dir/good.json" --cache "" --report "$dir/r.html"
grep -q "<svg" "$dir/r.html" || { echo "FAILED: no plot in the report"; failures=$((failures + 1)); }
expect "a mistake is named with line and field" 1 "bad.json:6: hand.tool: no body is called bell; there are ball" "$demos" --scene "$dir/bad.json"
[ ! -s "$dir/out" ] || { echo "FAILED: a refused scene wrote to stdout"; failures=$((failures + 1)); }
expect "a missing file is named" 1 "$dir/none.json: cannot be read" "$demos" --scene "$dir/none.json"
expect "a scene says all by itself" 2 "--scene goes without" "$demos" --scene "$dir/good.json" --spheres 10
expect "a folder is no scene" 1 "$dir: cannot be read" "$demos" --scene "$dir"
expect "the figures take their scenes from where one says" 1 "$dir/bunny.json: cannot be read" "$demos" --paper-figures "$dir/figures" --scenes "$dir"
expect "the figures run in real time" 2 "--paper-figures goes without --virtual-time" "$demos" --paper-figures "$dir/figures" --virtual-time
expect "the figures have their own meshes" 2 "--paper-figures goes without --mesh" "$demos" --paper-figures "$dir/figures" --mesh x.obj
expect "scenes are for the figures" 2 "--scenes goes with --paper-figures" "$demos" --scenes "$dir" --demo continuity
expect "continuity has no world" 2 "--demo continuity goes without --world-rate" "$demos" --demo continuity --world-rate 100
expect "the Z-width has no mesh" 2 "--demo z-width goes without --mesh" "$demos" --demo z-width --mesh x.obj
expect "a scene needs a file" 2 "--scene needs a value" "$demos" --scene
exit $((failures > 0))
