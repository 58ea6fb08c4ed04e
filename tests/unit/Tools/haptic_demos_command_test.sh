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
	if [ "$code" -ne "$wanted" ] || { [ -n "$words" ] && ! grep -qF -- "$words" "$dir/err"; }; then
		echo "FAILED $name: exit $code, wanted $wanted and '$words'"
		cat "$dir/err"
		failures=$((failures + 1))
	fi
	if grep -q $'\r' "$dir/err" "$dir/out"; then
		echo "FAILED $name: a carriage return, though this is no terminal"
		failures=$((failures + 1))
	fi
	if grep -vE '^[a-z ]+ [0-9]*0 %$' "$dir/err" | grep ' %$' || grep ' %$' "$dir/err" | sort | uniq -d | grep .; then
		echo "FAILED $name: more than a line for each tenth of a stage"
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
echo '{"schema": 1, "bodies": [{"name": "pea", "sphere": 0.01}]}' > "$dir/handless.json"

expect "an economy beyond its range" 2 "--economy must be off or a number from 0 to 0.5" "$demos" --demo hello --headless --economy 0.7
expect "an economy of a scene file" 2 "only the browser's demos know it" "$demos" --scene "$dir/good.json" --economy off
for economy in off 0 0.05; do
	expect "a demo with economy $economy" 0 "" "$demos" --demo hello --headless --frames 30 --json --cache "$dir" --economy $economy
	python3 -c "
import json
r = json.load(open('$dir/out'))['report'][0]
assert r['schema'] == 1 and r['economy'] == ('$economy' != 'off') and r['queries'] > 0 and len(r['pairs']) == 3, r
assert (r['kept'] > 0) == ('$economy' != 'off'), r
" || failures=$((failures + 1))
done
expect "a value in place of a scene's" 0 "" "$demos" --scene "$dir/good.json" --virtual-time --cache "" --json \
	--set duration=0.1 --set topology=contact-in-tick
python3 -c "
import json
r = json.load(open('$dir/out'))
assert r['ticks'] == 100 and r['topology'] == 'contact-in-tick' and r['last_force_n'] == 0, r
" || failures=$((failures + 1))
expect "a value without a field" 2 "--set wants FIELD=VALUE, not duration" "$demos" --scene "$dir/good.json" --set duration
expect "a field that is not there" 1 "hands" "$demos" --scene "$dir/good.json" --set "hands[0].device=sim:touch"
expect "a hand that presses and has a path" 1 "leave out press, or the path" "$demos" --scene "$dir/good.json" --cache "" \
	--set 'hand.device=sim:touch?press=0.01' --set 'hand.path=[{"time":0,"position":[0,0,0]}]'
expect "a path and a device that moves by itself" 1 "leave the path out, and set" "$demos" --scene "$dir/good.json" --cache "" \
	--set hand.device=dhd:0 --set 'hand.path=[{"time":0,"position":[0,0,0]}]'
expect "a value for a demo" 2 "--set goes with --scene" "$demos" --demo hello --set duration=1
expect "a good scene runs" 0 "" "$demos" --scene "$dir/good.json" --virtual-time --cache "" --json
python3 -c "
import json, sys
r = json.load(open('$dir/out'))
assert r['schema'] == 1 and r['ok'] is True and r['ticks'] == 200 and r['rate_hz'] is None, r
" || failures=$((failures + 1))
expect "a good scene runs at its own pace" 0 "report: $dir/r.html" "$demos" --scene "$dir/good.json" --cache "" --report "$dir/r.html"
grep -q "<svg" "$dir/r.html" || { echo "FAILED: no plot in the report"; failures=$((failures + 1)); }
expect "a mistake is named with line and field" 1 "bad.json:6: hand.tool: no body is called bell; there are ball" \
	"$demos" --scene "$dir/bad.json"
[ ! -s "$dir/out" ] || { echo "FAILED: a refused scene wrote to stdout"; failures=$((failures + 1)); }
echo '{"schema": 1, "name": "one", "timeLimit": 0.1, "conditions": [{"name": "a", "scene": "good.json"}]}' > "$dir/study.json"
study=("$demos" --study "$dir/study.json" --results "$dir" --virtual-time --cache "")
expect "a study runs" 0 "trial 1 of 1" "${study[@]}" --participant 7 --json
python3 -c "
import csv, json
r = json.load(open('$dir/out'))
assert r['schema'] == 1 and r['ok'] is True and r['participant'] == 7 and len(r['trials']) == 1, r
trials, samples = list(csv.DictReader(open(r['trials_file']))), list(csv.DictReader(open(r['samples_file'])))
assert trials[0]['device'] == 'sigma.7' and trials[0]['participant'] == '7' and len(samples) == 11, (trials, len(samples))
" || failures=$((failures + 1))
expect "a study makes its folder" 0 "" "${study[@]}" --participant 1 --results "$dir/new/folder"
[ -s "$dir/new/folder/one-p1-trials.csv" ] || { echo "FAILED: no results in a new folder"; failures=$((failures + 1)); }
expect "a study replaces no results" 1 "$dir/one-p7-trials.csv is there already" "${study[@]}" --participant 7
expect "a study says the participant's trials" 0 "" "${study[@]}" --participant 8
grep -q "^Trial 1, a *0.1 s, ended by time limit$" "$dir/out" || { echo "FAILED: a study's table"; failures=$((failures + 1)); }
expect "a study knows its participant" 2 "--study needs --participant N" "${study[@]}"
expect "participants count from 1" 2 "--participant must be a positive whole number, not 0" "${study[@]}" --participant 0
expect "participants are for studies" 2 "--participant goes with --study" "$demos" --scene "$dir/good.json" --participant 1
expect "a study has no report" 2 "--study goes without --report" "${study[@]}" --participant 1 --report "$dir/x.html"
expect "the device of a study has an address" 1 "--device: No device scheme matches 'sigma7'" \
	"${study[@]}" --participant 9 --device sigma7
expect "a session needs a hand" 1 "$dir/handless.json:1: hand: is missing: a session needs one, such as" \
	"$demos" --scene "$dir/handless.json"
expect "a missing file is named" 1 "$dir/none.json: cannot be read" "$demos" --scene "$dir/none.json"
expect "a scene says all by itself" 2 "--scene goes without" "$demos" --scene "$dir/good.json" --spheres 10
expect "a folder is no scene" 1 "$dir: cannot be read" "$demos" --scene "$dir"
expect "the figures take their scenes from where one says" 1 "$dir/bunny.json: cannot be read" \
	"$demos" --paper-figures "$dir/figures" --scenes "$dir"
expect "without a window there must be something to run" 2 "--headless needs --demo NAME or --scene FILE" "$demos" --headless
expect "nor is there anything to report" 2 "--report needs --demo NAME or --scene FILE" "$demos" --report "$dir/none.html"
expect "the figures run in real time" 2 "--paper-figures goes without --virtual-time" "$demos" --paper-figures "$dir/figures" --virtual-time
expect "the figures have their own meshes" 2 "--paper-figures goes without --mesh" "$demos" --paper-figures "$dir/figures" --mesh x.obj
expect "an assembly takes its scenes from where one says" 1 "$dir/assembly-one-hand.json: cannot be read" \
	"$demos" --demo assembly --scenes "$dir"
expect "a folder of scenes that is not there" 1 "there is no folder $dir/none here: name that of the scene files by --scenes" \
	"$demos" --demo assembly --scenes "$dir/none"
expect "scenes are for the figures" 2 "--scenes goes with --paper-figures" "$demos" --scenes "$dir" --demo continuity
expect "continuity has no world" 2 "--demo continuity goes without --world-rate" "$demos" --demo continuity --world-rate 100
expect "the Z-width has no mesh" 2 "--demo z-width goes without --mesh" "$demos" --demo z-width --mesh x.obj
expect "a grasp of a mesh that is not there" 1 "x.obj" "$demos" --demo grasps --mesh x.obj
expect "a mass needs a mesh" 2 "--mass goes with --demo grasps --mesh FILE" "$demos" --demo grasps --mass 1
expect "an axis needs a mesh" 2 "--up goes with --mesh" "$demos" --demo grasps --up z
expect "an axis is checked" 2 "--up must be an axis like z or -x, or two like z,y, not w" "$demos" --demo grasps --mesh x.obj --up w
expect "a friction is checked" 2 "--friction must be a number from 0.05 to 5, not -1" "$demos" --demo grasps --mesh x.obj --friction -1
expect "a mass is checked" 2 "--mass must be a number of kg from 0.001 to 10, not 1kg" "$demos" --demo grasps --mesh x.obj --mass 1kg
expect "a unit is checked" 2 "--unit must be m, cm, mm, um, in, ft, or a positive" "$demos" --demo grasps --mesh x.obj --unit miles
# A post of 40 mm x 40 mm x 160 mm with z up lies across the hand if it is not turned.
printf 'v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nv -2 -2 16\nv 2 -2 16\nv 2 2 16\nv -2 2 16\n' > "$dir/post.obj"
printf 'f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n' >> "$dir/post.obj"
expect "a lying post is refused with the turn" 1 "turn it (--up z makes it 40 mm wide there), or give another --unit" \
	"$demos" --demo grasps --mesh "$dir/post.obj" --unit cm
expect "grasps have their own trees" 2 "--demo grasps goes without --spheres" "$demos" --demo grasps --spheres 100
expect "a comparison has its own bodies" 2 "--demo grasp-compare goes without --mesh" "$demos" --demo grasp-compare --mesh x.obj
expect "the load has its own spheres" 2 "--demo grasp-load goes without --spheres" "$demos" --demo grasp-load --spheres 10
expect "a scene needs a file" 2 "--scene needs a value" "$demos" --scene
# A cube, and a spike whose one sphere lies far below the surface that the probe follows: its surface answers all the same.
corners='v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n'
printf "${corners}f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n" > "$dir/cube.obj"
printf 'v 1 0 0\nv 0 0 1\nv -1 0 -1\nv 0 100 0\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' > "$dir/spike.obj"
expect "a mesh that is turned about is the same cube" 0 "" \
	"$demos" --demo bunny-query --mesh "$dir/cube.obj" --up z --unit mm --spheres 100 --cache "" --json
for row in "cube 1000" "spike 1"; do
	set -- $row
	expect "the query of a $1" 0 "" "$demos" --demo bunny-query --mesh "$dir/$1.obj" --spheres $2 --cache "" --json
	python3 -c "
import json
r = json.load(open('$dir/out'))
assert r['schema'] == 1 and r['demo'] == 'bunny-query' and r['ok'] is True and r['max_force_n'] > 0, r
" || failures=$((failures + 1))
done
expect "a wrong name is said" 2 "no demo is called nonsense" "$demos" --demo nonsense
expect "a missing mesh is named" 1 "$dir/none.obj" "$demos" --demo packing --headless --cache "" --mesh "$dir/none.obj"
expect "a demo runs without a window" 0 "" "$demos" --demo heavy-on-light --headless --json --spheres 30 --cache "" --frames 5 --dt 0.01
python3 -c "
import json
r = json.load(open('$dir/out'))
assert r['schema'] == 1 and r['ok'] is True and r['frames'] == 5 and r['complete'] is False and abs(r['seconds'] - 0.05) < 1e-9, r
assert all(set(f) == {'name', 'unit', 'value', 'expected', 'tolerance', 'ok'} for f in r['figures']), r
" || failures=$((failures + 1))
expect "a demo writes a report" 0 "report: $dir/h.html" \
	"$demos" --demo heavy-on-light --spheres 30 --cache "" --frames 5 --report "$dir/h.html"
grep -q "<table" "$dir/h.html" || { echo "FAILED: no table in the report"; failures=$((failures + 1)); }
"$demos" --list | grep -q "^floating" || { echo "FAILED: a demo is not listed"; failures=$((failures + 1)); }
expect "sizes are checked" 2 "--size must be like 960x540" "$demos" --demo hello --headless --size 12
expect "steps are checked" 2 "--dt must be a positive number" "$demos" --demo hello --headless --dt -1
expect "spheres are counted" 2 "--spheres must be a positive whole number, not 2.7" "$demos" --demo hello --headless --spheres 2.7
expect "so many spheres there are not" 2 "--spheres must be a positive whole number, not 1e300" \
	"$demos" --demo hello --headless --spheres 1e300
expect "a scene's file has a name" 2 "--scene needs a value" "$demos" --scene "" --json
expect "forces want a device" 2 "--forces goes with --device" "$demos" --demo bunny --forces
expect "a device wants a window" 2 "--device goes without --headless" \
	"$demos" --demo hello --headless --frames 5 --device sim:touch --forces
expect "a picture is not made by a device" 2 "--device goes without --screenshot" \
	"$demos" --demo hello --frames 5 --device sim:touch --screenshot "$dir/x.png"
expect "a saved scene wants a demo" 2 "--save-scene needs --demo" "$demos" --save-scene x.json
expect "a gallery's folder has a name" 2 "--gallery needs a value" "$demos" --gallery ""
expect "counts are checked" 2 "--frames must be a positive whole number" "$demos" --demo hello --headless --frames 1.5
expect "other demos take no picture" 2 "only the browser's demos know it" "$demos" --demo continuity --screenshot x.png
expect "the browser has no clock" 2 "the browser goes without --virtual-time" "$demos" --demo hello --virtual-time
if "$demos" --demo heavy-on-light --spheres 30 --cache "" --frames 2 --screenshot "$dir/p.png" >/dev/null 2>"$dir/err"; then
	python3 -c "
import struct
d = open('$dir/p.png', 'rb').read()
assert d[:4] == b'\\x89PNG' and struct.unpack('>II', d[16:24]) == (960, 540)
" || failures=$((failures + 1))
	expect "a picture that cannot be written is said" 1 "$dir/no/p.png: the picture cannot be written" \
		"$demos" --demo heavy-on-light --spheres 30 --cache "" --frames 2 --screenshot "$dir/no/p.png"
	expect "a recording has a picture of the beginning and of every thirtieth of a second" 0 "" \
		"$demos" --demo heavy-on-light --spheres 30 --cache "" --frames 12 --size 64x36 --record "$dir/film"
	[ "$(ls "$dir/film" | wc -l)" -eq 7 ] || { echo "FAILED: $(ls "$dir/film" | wc -l) pictures in 0.2 s"; failures=$((failures + 1)); }
else
	grep -qE "apt-get install" "$dir/err" || { echo "FAILED: no pictures, and nobody says what to install"; failures=$((failures + 1)); }
fi
exit $((failures > 0))
