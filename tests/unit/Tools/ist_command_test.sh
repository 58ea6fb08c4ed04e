#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Usage: ist_command_test.sh PATH_TO_IST. Exit code 0 when every expectation holds.
set -u
ist=$1
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
failures=0

# expect NAME WANTED_CODE COMMAND...: stdout goes to $dir/out, stderr to $dir/err.
expect()
{
	local name=$1 wanted=$2
	shift 2
	"$@" > "$dir/out" 2> "$dir/err"
	local code=$?
	if [ "$code" -ne "$wanted" ]; then
		echo "FAILED $name: exit $code, wanted $wanted"
		cat "$dir/err"
		failures=$((failures + 1))
	fi
}

# holds NAME EXPRESSION...: Python over `rows`, the JSON objects of the last output, and `r`, the first of them.
# Several arguments are one expression, joined by spaces.
holds()
{
	if ! python3 - "$dir/out" "${*:2}" <<'PYTHON'
import json, math, sys
rows = [json.loads(line) for line in open(sys.argv[1]) if line.strip()]
r = rows[0] if rows else {}
def near(a, b, e=1e-9): return abs(a - b) <= e
sys.exit(0 if eval(sys.argv[2]) else 1)
PYTHON
	then
		echo "FAILED $1: ${*:2}"
		head -c 2000 "$dir/out"
		failures=$((failures + 1))
	fi
}

says()
{
	if ! grep -q -- "$2" "$dir/err"; then
		echo "FAILED $1: no \"$2\" in: $(cat "$dir/err")"
		failures=$((failures + 1))
	fi
}

# A cube of side 1 whose lower corner is the origin.
cat > "$dir/cube.obj" <<'OBJ'
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
OBJ
cube=$dir/cube.ist

expect version 0 "$ist" --version
expect help 0 "$ist" build --help
expect "no command" 2 "$ist"
expect "unknown command" 2 "$ist" biuld "$dir/cube.obj"
says "unknown command" 'there is no command "biuld"; the nearest is "build"'
expect "no command is near" 2 "$ist" frobnicate
says "no command is near" 'there is no command "frobnicate"; all are: build, info, check'

expect build 0 "$ist" build "$dir/cube.obj" -o "$cube" --spheres 300 --json
holds build 'r["schema"] == 1 and r["spheres"] == 300 and r["leaves"] >= 300 and near(r["volume"], 1) and near(r["area"], 6)'
holds "build fields" 'set("spheres leaves fill volume mesh_volume area longest_side seconds seconds_setup seconds_packing' \
	'seconds_leaves seconds_tree watertight repair volume_change mean_gap max_gap min_radius uncovered_area bytes' \
	'peak_memory_bytes bytes_per_leaf surface_elements surface_cells surface_error surface_max_error surface_bytes' \
	'sagitta".split()) <= set(r)'
holds "build values" '0.5 < r["fill"] < 1 and r["watertight"] is True and r["peak_memory_bytes"] > 0 and r["min_radius"] > 0'
expect "build to standard output" 1 "$ist" build "$dir/cube.obj" -o - --spheres 30
says "build to standard output" "name a file"
expect "export to standard output" 0 "$ist" export "$cube" --spheres -
[ "$(wc -l < "$dir/out")" -eq 301 ] || { echo "FAILED export to standard output"; failures=$((failures + 1)); }
expect "export both to standard output" 1 "$ist" export "$cube" --spheres - --leaves -
[ ! -e ./- ] || { echo "FAILED: a file named -"; failures=$((failures + 1)); }
expect "query of a mesh" 1 "$ist" query "$dir/cube.obj" "$cube" --pose 0,0,0,0,0,0,1
says "query of a mesh" "make a tree of it: ist build $dir/cube.obj -o cube.ist"
expect "query of meshes without a pose" 1 "$ist" query "$dir/cube.obj" "$dir/cube.obj"
says "query of meshes without a pose" "make a tree of it: ist build $dir/cube.obj -o cube.ist"
expect "query without a pose" 2 "$ist" query "$cube" "$cube"
says "query without a pose" "a query needs the pose of B in A's mesh frame: --pose"
expect "text of info" 0 "$ist" info "$cube"
grep -q '^volume  *1 m^3$' "$dir/out" || { echo "FAILED text of info"; failures=$((failures + 1)); }
expect "build by many threads" 0 "$ist" build "$dir/cube.obj" -o "$dir/many.ist" --spheres 300 --threads 64 --json
holds "build by many threads" 'r["peak_memory_bytes"] < 1e9'
cmp -s "$cube" "$dir/many.ist" || { echo "FAILED build by many threads: another asset"; failures=$((failures + 1)); }
expect "build to tune" 0 "$ist" build "$dir/cube.obj" -o "$dir/tuned.ist" --spheres 1000 --quiet
tuned=$dir/tuned.ist
expect tune 0 "$ist" tune "$tuned" "$tuned" --error 0.9 --json
holds tune 'r["kept"] and r["error"] <= 0.9 and r["spheres"] == 1000 and r["time_us"] > 0 and {"level", "spheres_a", "spheres_b"} <= set(r)'
holds "tune's answer is its cheapest alternative that will do" \
	'r["time_us"] == min(a["time_us"] for a in r["alternatives"] if a["error"] <= 0.9 and a["level"] != "by pose")'
holds "tune: finer levels have more pairs" \
	'all(a["pairs"] > b["pairs"] for a, b in zip(r["alternatives"][1:-1], r["alternatives"][2:-1])) and len(r["alternatives"]) > 4' \
	'and r["alternatives"][0]["error"] < 0.1 * r["alternatives"][1]["error"]'
expect "build leaves to tune" 0 "$ist" build "$dir/cube.obj" -o "$dir/tuned_leaves.ist" --spheres 1000 --no-surface --quiet
expect "tune a mesh" 0 "$ist" tune "$dir/cube.obj" "$dir/tuned_leaves.ist" --error 0.2 --max-spheres 2000 --json
holds "tune a mesh" 'r["spheres_b"] == 1000 and 1000 < r["spheres_a"] <= 2000'
holds "tune counts patches" '1 <= r["patches"] <= 8 and all(a["patches"] <= 8 for a in r["alternatives"])'
holds "tune without a world" '"substeps" not in r and "precision" not in r'
expect "tune a world" 0 "$ist" tune "$tuned" "$tuned" --error 0.9 --stiffness 1e5 --mass 2 --speed 3 --step 0.05 --distance 10 --json
holds "tune: the contact carries the weight" \
	'near(r["rest_depth_m"] * r["frequency_rad_s"] ** 2, 9.81, 1e-6) and r["frequency_rad_s"] ** 2 < 1e5 / 2 * 3'
holds "tune: explicit limit" \
	'near(r["explicit_step_s"] * r["frequency_rad_s"], 2, 1e-9) and r["explicit"] == (1 / r["rate_hz"] < r["explicit_step_s"])'
holds "tune: restitution" 'near(math.exp(-math.pi / 2 * r["restitution_step_s"] * r["frequency_rad_s"]), 0.1, 1e-9)'
holds "tune: thickness of a cube" 'near(r["thickness_step_s"] * 3, 0.25 / 3, 1e-4)'
holds "tune: substeps" 'r["substeps"] == math.ceil(0.05 / min(r["restitution_step_s"], r["thickness_step_s"])) > 1' \
	'and near(r["rate_hz"], r["substeps"] / 0.05, 1e-6)'
holds "tune: float is enough" 'r["precision"] == "float"'
expect "tune far away" 0 "$ist" tune "$tuned" "$tuned" --error 0.9 --stiffness 1e6 --mass 2 --distance 1e5 --json
holds "tune: double is needed" 'r["precision"] == "double" and r["substeps"] == 1 and r["restitution_step_s"] is None' \
	'and 2 ** (16 - 23) > 0.9 * r["rest_depth_m"]'
expect "tune half a world" 2 "$ist" tune "$tuned" "$tuned" --error 0.9 --stiffness 1e6
expect "tune out of reach" 1 "$ist" tune "$cube" "$cube" --error 0.001 --json
says "tune out of reach" "out of reach"
holds "tune out of reach" 'r["kept"] is False and r["error"] > 0.001'
expect "tune nothing" 1 "$ist" tune "$cube" "$dir/none.ist" --error 0.1
expect "tune without error" 2 "$ist" tune "$cube" "$cube"
expect "tune to a wrong error" 2 "$ist" tune "$cube" "$cube" --error 2
holds "nothing is printed" 'not rows'
expect "build --error" 0 "$ist" build "$dir/cube.obj" -o "$dir/error.ist" --error 0.3 --json
holds "build --error" 'r["spheres"] <= 1000'
expect "build --error out of reach" 1 "$ist" build "$dir/cube.obj" -o "$dir/no.ist" --error 0.001 --spheres 50
says "build --error out of reach" "out of reach: 50 spheres give .*; allow more spheres (--spheres)"
# Two cubes far from the origin, one of them inside out. The volume that they enclose as they are is nothing but rounding,
# so no relative change of it can be told.
python3 - > "$dir/opposed.obj" <<'PYTHON'
corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
faces = ((1, 4, 3, 2), (5, 6, 7, 8), (1, 2, 6, 5), (2, 3, 7, 6), (3, 4, 8, 7), (4, 1, 5, 8))
for x in 0.1, 2.1:
    for v in corners: print("v", 0.7 * v[0] + x, 0.7 * v[1] + 0.3, 0.7 * v[2] - 0.2)
for f in faces: print("f", *f)
for f in faces: print("f", *(8 + i for i in reversed(f)))
PYTHON
expect "build of nothing but rounding" 0 "$ist" build "$dir/opposed.obj" -o "$dir/opposed.ist" --spheres 20 --json
holds "build of nothing but rounding" 'r["volume_change"] is None and near(r["volume"], 2 * 0.7 ** 3, 1e-6)' \
	'and 0 < abs(r["mesh_volume"]) < 1e-6 and any("volume changed from" in t for t in r["repair"])'

# A tube: closing it may change its volume by 71 %.
sed '/^f 1 4 3 2/d; /^f 5 6 7 8/d' "$dir/cube.obj" > "$dir/tube.obj"
expect "build of a tube" 1 "$ist" build "$dir/tube.obj" -o "$dir/tube.ist" --spheres 20
says "build of a tube" \
	"may be off by .* m^3 (71 %).*--repair wrap.*--accept-doubt.*Closed 2 holes, the largest 1.41421 m across at (0.5, 0.5, [01]) m"
[ ! -e "$dir/tube.ist" ] || { echo "FAILED build of a tube: a file"; failures=$((failures + 1)); }
for more in "" "--error 0.9"; do
	expect "build of a tube all the same $more" 0 "$ist" build "$dir/tube.obj" -o "$dir/tube.ist" --spheres 20 --accept-doubt $more --json
	holds "build of a tube all the same $more" 'near(r["volume"], 1, 1e-6) and near(r["volume_doubt"], 0.7071, 1e-3)'
	says "build of a tube all the same $more" "warning: .*(71 %)"
done
head -n 13 "$dir/cube.obj" > "$dir/holed.obj"
for mode in auto wrap; do
	expect "build --repair $mode" 0 "$ist" build "$dir/holed.obj" -o "$dir/holed.ist" --spheres 50 --repair $mode --json
	holds "build --repair $mode" 'r["watertight"] is False and abs(r["volume"] - 1) < 0.01' \
		'and near(r["volume_change"], r["volume"] / abs(r["mesh_volume"]) - 1)' \
		'and any("volume changed from" in t for t in r["repair"])'
	expect "check after --repair $mode" 0 "$ist" check "$dir/holed.ist" --mesh "$dir/holed.obj" --json
	holds "check after --repair $mode" 'r["ok"] is True and r["protruding"] == 0'
done
# A square of four triangles about a hill is open ground. Closed 0.5 m deep, it has 4 * 0.5 + 4 * 0.3 / 3 m^3.
printf 'v 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 0 2\nv 1 0.3 1\nf 1 5 2\nf 2 5 3\nf 3 5 4\nf 4 5 1\n' > "$dir/hill.obj"
expect "build of open ground" 1 "$ist" build "$dir/hill.obj" -o "$dir/none.ist" --spheres 50
says "build of open ground" "faces y, close it downwards .*--repair ground DEPTH"
for options in "--repair ground 0.5" "--repair=ground 0.5" "--up y,z --repair ground 0.5"; do
	expect "build $options" 0 "$ist" build $options "$dir/hill.obj" -o "$dir/hill.ist" --spheres 50 --json
	holds "build $options" 'abs(r["volume"] - 2.4) < 1e-6 and r["watertight"] is False and r["volume_doubt"] == 0' \
		'and any("Closed the surface downwards from 4 open edges" in t for t in r["repair"])'
	expect "check after $options" 0 "$ist" check "$dir/hill.ist" --mesh "$dir/hill.obj" --json
	holds "check after $options" 'r["ok"] is True and r["protruding"] == 0'
done
expect "build of ground along a wrong axis" 1 "$ist" build "$dir/hill.obj" -o "$dir/none.ist" --repair ground 1 --up x
says "build of ground along a wrong axis" "does not face y, .*; it faces x: name as up (--up) the axis of the file that became it"
# An axis that --repair names is one of the turned mesh, and stays.
expect "build of ground along a named axis" 0 "$ist" build "$dir/hill.obj" -o "$dir/hill.ist" --spheres 50 --repair "ground 0.5 x" --up y,x
expect "build of ground along another axis" 1 "$ist" build "$dir/hill.obj" -o "$dir/none.ist" --repair "ground 0.5 z" --up y,x
says "build of ground along another axis" "does not face z, .*; it faces x"
# The volume of an open surface means nothing, and so does its change.
expect "build --quiet of open ground" 0 "$ist" build "$dir/hill.obj" -o "$dir/hill.ist" --spheres 50 --repair "ground 0.5" --quiet
says "build --quiet of open ground" "^ist: warning: .*/hill.obj: repaired: .*Closed the surface downwards"
for depth in "" 0 -1 deep; do
	expect "build --repair ground $depth" 2 "$ist" build "$dir/hill.obj" --repair ground $depth -o "$dir/none.ist"
done
# The outcomes of a folder of meshes.
mkdir "$dir/meshes"
cp "$dir/cube.obj" "$dir/holed.obj" "$dir/hill.obj" "$dir/meshes"
outcomes=$(dirname "$0")/../../bench/mesh_outcomes.py
expect "outcomes of a folder" 0 python3 "$outcomes" "$ist" "$dir/meshes" -- --spheres 20 --no-surface
for line in "^cube.obj: built as it is in .* s: 1 m^3" "^holed.obj: built, doubt of more than 5 % said" \
	"^hill.obj: refused .*--repair ground" "^| refused | 1 |"; do
	grep -q -- "$line" "$dir/out" || { echo "FAILED outcomes of a folder: no $line" && cat "$dir/out"; failures=$((failures + 1)); }
done
# A farm that builds quietly hears of it; of a mesh that needed nothing, nothing.
expect "build --quiet" 0 "$ist" build "$dir/holed.obj" -o "$dir/holed.ist" --spheres 50 --quiet
says "build --quiet" \
	"^ist: warning: .*/holed.obj: repaired, volume .* %, 36 % of the volume is in doubt: .*Closed 1 hole, .*volume changed from"
[ "$(wc -l < "$dir/err")" -eq 1 ] && [ ! -s "$dir/out" ] || { echo "FAILED build --quiet: not one line"; failures=$((failures + 1)); }
# A closed plate of one cell and a half. The grid that was asked for is not refused, and its doubt is said, also with --quiet.
sed 's/^v \(.*\) \(.*\) 1$/v \1 \2 0.012/' "$dir/cube.obj" > "$dir/plate.obj"
for more in "" "--quiet"; do
	expect "build of a plate --repair wrap $more" 0 "$ist" build "$dir/plate.obj" -o "$dir/plate.ist" --spheres 50 --repair wrap $more
	says "build of a plate --repair wrap $more" "^ist: warning: .*/plate.obj: .*\(6[0-9]\|7[0-9]\) %"
done
# The rebuilt volume is the file's up to the noticed change, and the doubt is said all the same.
sed 's/^v \(.*\) \(.*\) 1$/v \1 \2 0.125/' "$dir/cube.obj" > "$dir/slab.obj"
expect "build of a slab --repair wrap --quiet" 0 "$ist" build "$dir/slab.obj" -o "$dir/slab.ist" --spheres 50 --repair wrap --quiet
says "build of a slab --repair wrap --quiet" "^ist: warning: .*/slab.obj: .*, [0-9]* % of the volume is in doubt"
# What a file holds and cannot be taken is said before the repair, across the process that reads the file.
{
	printf 'ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n'
	printf 'element face 8\nproperty list uchar int vertex_indices\nend_header\n'
	printf '0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n'
	printf '4 0 3 2 1\n4 4 5 6 7\n4 0 1 8 4\n4 0 1 5 4\n4 2 3 7 6\n4 0 4 7 3\n4 1 2 6 5\n2 0 1\n'
} > "$dir/damaged.ply"
expect "build of a damaged file" 0 "$ist" build "$dir/damaged.ply" -o "$dir/damaged.ist" --spheres 50 --json
holds "build of a damaged file" 'r["repair"][0].startswith("1 of 7 faces was left out: ")' \
	'and r["repair"][1].startswith("1 line was left out: ") and near(r["volume"], 1)'
expect "build --quiet of a damaged file" 0 "$ist" build "$dir/damaged.ply" -o "$dir/damaged.ist" --spheres 50 --quiet
says "build --quiet of a damaged file" "^ist: warning: .*/damaged.ply: repaired, .*1 of 7 faces was left out"
expect "check with a damaged file" 0 "$ist" check "$dir/damaged.ist" --mesh "$dir/damaged.ply" --json
says "check with a damaged file" "^ist: warning: .*/damaged.ply: 1 of 7 faces was left out"
sed 's/^4 0 4 7 3$/4 0 4 9 3/; s/^4 1 2 6 5$/4 1 2 6 9/; s/^4 2 3 7 6$/4 2 9 7 6/' "$dir/damaged.ply" > "$dir/ruined.ply"
expect "build of a ruined file" 1 "$ist" build "$dir/ruined.ply" -o "$dir/no.ist"
says "build of a ruined file" "4 of its 7 faces name corners that are not in the file"

expect "build --repair off" 1 "$ist" build "$dir/holed.obj" -o "$dir/no.ist" --spheres 50 --repair off
says "build --repair off" "4 open edges, the first at"
rm -f "$dir/holed.ist"
sed 's/^v \(.*\) \(.*\) \(.*\)/v \1e8 \2e8 \3e8/' "$dir/cube.obj" > "$dir/huge.obj"
expect "build of a huge mesh" 1 "$ist" build "$dir/huge.obj" -o "$dir/no.ist" --spheres 50
says "build of a huge mesh" "give its unit (--unit), or scale it"
expect "build --fill 2" 2 "$ist" build "$dir/cube.obj" -o "$dir/no.ist" --fill 2
for wrong in "--min-radius 0" "--min-radius nan" "--seed -1" "--seed 1.5" "--seed 99999999999999999999" "--threads 0"; do
	expect "build $wrong" 2 "$ist" build "$dir/cube.obj" -o "$dir/no.ist" $wrong
	[ "$(head -n 1 "$dir/err" | wc -c)" -le 80 ] || { echo "FAILED build $wrong: $(cat "$dir/err")"; failures=$((failures + 1)); }
done
for zeros in 10 010 00010; do
	expect "build --spheres $zeros" 0 "$ist" build "$dir/cube.obj" -o "$dir/ten.ist" --spheres $zeros --seed 0$zeros --threads 02 --json
	holds "build --spheres $zeros" 'r["spheres"] == 10'
	cp "$dir/ten.ist" "$dir/ten_$zeros.ist"
	cmp "$dir/ten_10.ist" "$dir/ten_$zeros.ist" || { echo "FAILED build --seed 0$zeros"; failures=$((failures + 1)); }
done
for option in spheres seed threads; do
	for wrong in 0x10 010x 1e2 1.0 " 5" ""; do
		expect "build --$option '$wrong'" 2 "$ist" build "$dir/cube.obj" -o "$dir/no.ist" "--$option" "$wrong"
		says "build --$option '$wrong'" "whole number from"
	done
done
for option in level max-pairs threads repeat; do
	expect "query --$option 0x1" 2 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 "--$option" 0x1
done
expect "query --max-pairs 0900" 0 "$ist" query "$cube" "$cube" --pose 0.2,0.1,0.5,0,0,0,1 --max-pairs 0900 --json
holds "query --max-pairs 0900" '0 < r["pairs"] <= 900'
expect "build: missing mesh" 1 "$ist" build "$dir/none.obj" -o "$dir/no.ist"
expect "build: no name" 1 "$ist" build "$dir/cube.obj" -o "" --spheres 10
says "build: no name" "has no name"
expect "build: missing folder" 1 "$ist" build "$dir/cube.obj" -o "$dir/none/no.ist" --spheres 10
if ls "$dir"/no.ist* "$dir"/.tmp* > /dev/null 2>&1; then
	echo "FAILED: a failed build left a file"
	failures=$((failures + 1))
fi

# Files on which assimp 5.2.5 aborts, reads what is not there, or asks for all memory: one sentence, whatever happens to its reader.
ply='ply\nformat %s 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n'
ply+='element face 4\nproperty list uchar int vertex_indices\nend_header\n'
printf 'OFF\n4 4 6\n0 0 0\n1 0 0\n' > "$dir/short.off"
printf "${ply}abc" binary_little_endian > "$dir/short.ply"
printf "${ply}0 0 0\n1 0 0\n0 1 0\n0 0 1\n300000000 0 2 1\n" ascii > "$dir/endless.ply"
limited=unlimited  # what sanitizers need, which also have more to say
(ulimit -v 1500000; "$ist" --version) > /dev/null 2>&1 && limited=1500000
for damaged in short.off short.ply endless.ply; do
	[ $damaged = endless.ply ] && [ $limited = unlimited ] && continue
	expect "build $damaged" 1 bash -c 'ulimit -v $0; exec "$@"' $limited "$ist" build "$dir/$damaged" -o "$dir/no.ist" --quiet
	says "build $damaged" "^ist: .*$damaged"
	[ $limited = unlimited ] || [ "$(wc -l < "$dir/err")" -eq 1 ] || {
		echo "FAILED build $damaged: $(cat "$dir/err")"
		failures=$((failures + 1))
	}
done
expect "check with a damaged mesh" 1 "$ist" check "$cube" --mesh "$dir/short.off"
says "check with a damaged mesh" "^ist: .*short.off"

# Nobody's mesh or asset is lost to a slip of the keyboard, and nobody waits for what cannot be kept.
ln -s cube.obj "$dir/link.obj"
cp "$dir/cube.obj" "$dir/kept.obj"
expect "build: missing folder, before any work" 1 "$ist" build "$dir/cube.obj" -o "$dir/none/no.ist"
grep -q import "$dir/err" && { echo "FAILED build: missing folder: worked in vain"; failures=$((failures + 1)); }
for name in cube.obj link.obj; do
	expect "build onto $name" 1 "$ist" build "$dir/cube.obj" -o "$dir/$name" --spheres 10
	says "build onto $name" "is the file that is read"
done
cmp -s "$dir/cube.obj" "$dir/kept.obj" || { echo "FAILED build: the mesh was overwritten"; failures=$((failures + 1)); }
expect "pack onto itself" 1 "$ist" pack "$cube" -o "$cube"
expect "unpack onto itself" 1 "$ist" unpack "$cube" -o "$cube"
expect "export onto the asset" 1 "$ist" export "$cube" --leaves "$cube"
expect "query onto an asset" 1 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 --pairs-out "$cube"
holds "query onto an asset" 'not rows'

expect "build in mm" 0 "$ist" build "$dir/cube.obj" -o "$dir/small.ist" --spheres 50 --unit mm --json
holds "build in mm" 'near(r["volume"], 1e-9, 1e-18) and near(r["longest_side"], 1e-3, 1e-9)'

holds "build in mm says so" 'r["unit"] == "mm" and not any("unit" in s for s in r["repair"])'

for unit in um:1e-6 in:0.0254 ft:0.3048 0.5:0.5; do
	expect "build in ${unit%:*}" 0 "$ist" build "$dir/cube.obj" -o "$dir/small.ist" --spheres 20 --unit "${unit%:*}" --json
	holds "build in ${unit%:*}" "near(r[\"longest_side\"] / ${unit#*:}, 1, 1e-6) and r[\"unit\"] in (\"${unit%:*}\", ${unit#*:})"
done
for unit in km 0 -1 1m nan; do expect "build in $unit" 2 "$ist" build "$dir/cube.obj" -o "$dir/small.ist" --unit=$unit; done
expect "build of a large thing" 0 "$ist" build "$dir/cube.obj" -o "$dir/small.ist" --spheres 20 --unit 101
says "build of a large thing" "it is 101 m long; is that right? If not, give its unit (--unit)"
expect "build of a small thing" 0 "$ist" build "$dir/cube.obj" -o "$dir/small.ist" --spheres 20 --unit 9e-5 --quiet
says "build of a small thing" "it is 9e-05 m long; is that right?"
expect "info of a small thing" 0 "$ist" info "$dir/small.ist" --json
says "info of a small thing" "is that right?"
holds "info of a small thing" 'near(r["size"][2], 9e-5, 1e-12)'
# A cube of 1 m from the origin on: z becomes y, and y becomes -z.
expect "build turned" 0 "$ist" build "$dir/cube.obj" -o "$dir/turned.ist" --spheres 20 --up z --json
holds "build turned" 'r["up"] == "z"'
expect "info of a turned tree" 0 "$ist" info "$dir/turned.ist" --json
holds "info of a turned tree" 'near(r["center_of_mass"][1], 0.5) and near(r["center_of_mass"][2], -0.5)' \
	'and r["repair"][0] == "Turned the axes: z of the file became y."'
expect "check of a turned tree" 0 "$ist" check "$dir/turned.ist" --mesh "$dir/cube.obj" --json
holds "check of a turned tree" 'r["ok"] is True'
for up in w zz z, z,w ""; do expect "build with --up '$up'" 2 "$ist" build "$dir/cube.obj" -o "$dir/turned.ist" --up "$up"; done

# A COLLADA file in millimetres: its unit is applied once. A given unit takes its place, which is said. `check` finds the same mesh again.
cat > "$dir/mm.dae" << 'END'
<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 30 0 0 0 30 0 0 0 30</float_array><technique_common>
<accessor source="#a" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
END
for unit in "" "--unit mm"; do
	# Without quotes: nothing, or two words.
	expect "build a stated unit $unit" 0 "$ist" build "$dir/mm.dae" -o "$dir/stated.ist" --spheres 50 $unit --json
	holds "build a stated unit $unit" 'near(r["longest_side"], 0.03, 1e-8) and r["unit"] == "mm" and not any("unit" in s for s in r["repair"])'
	expect "check a stated unit $unit" 0 "$ist" check "$dir/stated.ist" --mesh "$dir/mm.dae" --json
	holds "check a stated unit $unit" 'r["ok"] is True'
done
expect "build over a stated unit" 0 "$ist" build "$dir/mm.dae" -o "$dir/stated.ist" --spheres 50 --unit cm --json
holds "build over a stated unit" 'near(r["longest_side"], 0.3, 1e-7) and r["unit"] == "cm"' \
	'and r["repair"][0] == "The file states 0.001 m as its unit; in its place the given unit was applied, 0.01 m."'
expect "check over a stated unit" 0 "$ist" check "$dir/stated.ist" --mesh "$dir/mm.dae" --json
holds "check over a stated unit" 'r["ok"] is True'

expect info 0 "$ist" info "$cube" --json
holds info 'r["version"] == 7 and r["bytes"] == r["bytes_per_sphere"] * 300 and r["seconds_load"] > 0 and r["spheres"] == 300' \
	'and r["unit"] == "m" and len(r["mesh_hash"]) == 16 and r["nodes"] > 0 and len(r["calibration"]["levels"]) > 2'
holds "info mass" 'near(r["longest_side"], 1) and all(near(v, 0.5) for v in r["center_of_mass"])' \
	'and all(near(v, 1/6 if i % 4 == 0 else 0) for i, v in enumerate(r["inertia"]))'

holds "info of the surface" '0 < r["surface_bytes"] < r["bytes"] and near(r["bytes_per_leaf"] * r["leaves"], r["bytes"], 1e-6)' \
	'and r["surface_elements"] > 0 and r["surface_cells"] > 0 and r["surface_error"] <= r["surface_max_error"] < 1e-6' \
	'and near(r["sagitta"], 0, 1e-9)'
expect "build without a surface" 0 "$ist" build "$dir/cube.obj" -o "$dir/leaves.ist" --spheres 300 --no-surface --quiet
expect "info without a surface" 0 "$ist" info "$dir/leaves.ist" --json
holds "info without a surface" 'r["surface_elements"] == 0 and r["surface_cells"] == 0 and near(r["sagitta"], 0, 1e-9)'

expect check 0 "$ist" check "$cube" --json
holds check 'r["ok"] is True and r["overlapping_pairs"] == 0 and r["max_overlap"] == 0' \
	'and r["max_protrusion"] is None and r["problems"] == []' \
	'and r["surface_elements"] > 0 and r["surface_area_error"] < 1e-5 and r["surface_open_area"] < 1e-5'
expect "check without a surface" 0 "$ist" check "$dir/leaves.ist" --json
holds "check without a surface" 'r["ok"] is True and r["surface_elements"] == 0 and r["surface_area_error"] is None'
expect "check with mesh" 0 "$ist" check "$cube" --mesh "$dir/cube.obj" --json
holds "check with mesh" 'r["ok"] is True and r["protruding"] == 0 and r["max_protrusion"] == 0'
sed 's/^v 1 1 1/v 0.9 0.9 0.9/' "$dir/cube.obj" > "$dir/other.obj"
expect "check with another mesh" 1 "$ist" check "$cube" --mesh "$dir/other.obj" --json
holds "check with another mesh" 'r["ok"] is False and r["protruding"] > 0 and r["max_protrusion"] > 0 and len(r["problems"]) == 2'

expect export 0 "$ist" export "$cube" --spheres "$dir/spheres.csv" --leaves "$dir/leaves.csv"
ln -s one.csv "$dir/one_link.csv"
for name in one.csv ./one.csv one_link.csv; do
	expect "export two things into $name" 1 "$ist" export "$cube" --spheres "$dir/one.csv" --leaves "$dir/$name"
	says "export two things into $name" "name two files"
	[ ! -e "$dir/one.csv" ] || { echo "FAILED export two things into $name: a file was left"; failures=$((failures + 1)); }
done
expect "export nothing" 2 "$ist" export "$cube"
[ "$(head -1 "$dir/spheres.csv")" = "x,y,z,r" ] && [ "$(wc -l < "$dir/spheres.csv")" -eq 301 ] || {
	echo "FAILED spheres.csv"
	failures=$((failures + 1))
}
[ "$(head -1 "$dir/leaves.csv")" = "x,y,z,r,density,nx,ny,nz,depth,sphere,xx,yy,zz,xy,xz,yz" ] || {
	echo "FAILED leaves.csv"
	failures=$((failures + 1))
}

expect pack 0 "$ist" pack "$cube" -o "$dir/cube.ista" --json
holds pack 'r["spheres"] == 300 and r["bytes_per_sphere"] < 0.5 * '"$(stat -c %s "$cube")"' / 300' \
	'and 0 <= r["fill_loss"] < 1e-3 and 0 <= r["max_radius_loss"] < 1e-5 and abs(r["leaf_volume_change"]) < 1e-4'
expect "info of an archive" 0 "$ist" info "$dir/cube.ista" --json
holds "info of an archive" 'r["spheres"] == 300 and near(r["volume"], 1)'
expect unpack 0 "$ist" unpack "$dir/cube.ista" -o "$dir/again.ist" --json
holds unpack 'r["spheres"] == 300'
expect "check of an unpacked asset" 0 "$ist" check "$dir/again.ist" --mesh "$dir/cube.obj" --json
holds "check of an unpacked asset" 'r["ok"] is True and r["overlapping_pairs"] == 0 and r["protruding"] == 0'
expect "pack: not an asset" 1 "$ist" pack "$dir/cube.obj" -o "$dir/no.ista"
says "pack: not an asset" "not an inner sphere tree"

# B's cube 0.9 above A's: overlap 0.1.
expect query 0 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 --stiffness 1000 --lower-bound --repeat 3 \
	--pairs-out "$dir/pairs.csv" --json
holds query 'r["row"] == 0 and near(r["volume"], 0.1, 0.02) and near(r["force"][2], -100, 20) and abs(r["force"][0]) < 5' \
	'and 0 <= r["volume_lower"] <= 0.1 and r["volume_sigma"] > 0'
holds "query fields" 'r["normal"][2] < -0.95 and near(r["centroid"][2], 0.95, 0.03) and len(r["stiffness"]) == 36' \
	'and r["distance"] == 0 and r["time_us"] > 0 and r["complete"] is True and r["patches"] >= 1 and r["energy"] > 0'
[ "$(wc -l < "$dir/pairs.csv")" -gt 1 ] || { echo "FAILED pairs.csv"; failures=$((failures + 1)); }
expect "query surface" 0 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 --stiffness 1000 --surface "$dir/surface.ply" --json
python3 - "$dir/surface.ply" "$dir/out" <<'EOF' || { echo "FAILED contact surface"; failures=$((failures + 1)); }
import json, sys
lines = open(sys.argv[1]).read().splitlines()
end = lines.index("end_header")
count = int(next(l for l in lines if l.startswith("element vertex")).split()[-1])
rows = [[float(x) for x in l.split()] for l in lines[end + 1:]]
force = [sum(r[3 + k] * r[6] * r[7] for r in rows) for k in range(3)]
told = json.loads(open(sys.argv[2]).read())["force"]
sizes = sum(r[6] * r[7] for r in rows)
sys.exit(not (lines[0] == "ply" and len(rows) == count > 10 and all(abs(a - b) < 1e-5 * sizes for a, b in zip(force, told))))
EOF
expect "query surface of leaves" 1 "$ist" query "$dir/leaves.ist" "$dir/leaves.ist" --pose 0,0,0.9,0,0,0,1 \
	--surface "$dir/no.ply" --pairs-out "$dir/no.csv"
expect "query apart" 0 "$ist" query "$cube" "$cube" --pose=-1.5,0,0,0,0,0,1 --json
holds "query apart" 'r["volume"] == 0 and r["normal"] is None and r["area_vector"] is None and r["distance"] >= 0.5 - 1e-6' \
	'and r["distance_lower"] <= 0.5 and r["force"] == [0, 0, 0]' \
	'and near(math.dist(r["nearest_a"], r["nearest_b"]), r["distance"], 1e-6)'
expect "query, negative pose" 0 "$ist" query "$cube" "$cube" --pose -0.9,0,0,0,0,0,1 --json
holds "query, negative pose" 'r["force"][0] > 0'
for law in paper energy volume; do
	expect "query $law" 0 "$ist" query "$cube" "$cube" --pose 0,0,0.5,0,0,0,1 --law $law --json
	holds "query $law" 'r["volume"] > 0.1 and (r["stiffness"] is None) == ("'$law'" != "energy")' \
		'and (r["force"] is None) == ("'$law'" == "volume")'
done
expect "query --level" 0 "$ist" query "$cube" "$cube" --pose 0.2,0.1,0.5,0,0,0,1 --level 1 --json
holds "query --level" 'r["level"] == 1 and abs(r["volume"] - 0.8 * 0.9 * 0.5) < 0.05'
expect "query --max-pairs" 0 "$ist" query "$cube" "$cube" --pose 0.2,0.1,0.5,0,0,0,1 --max-pairs 400 --json
holds "query --max-pairs" 'r["pairs"] <= 400 and r["complete"] is False and abs(r["volume"] - 0.8 * 0.9 * 0.5) < 0.05'
expect "query --blend" 0 "$ist" query "$cube" "$cube" --pose 0.2,0.1,0.5,0,0,0,1 --max-pairs 900 --blend --json
holds "query --blend" 'r["pairs"] <= 900 and 0 < r["level_share"] <= 1 and abs(r["volume"] - 0.8 * 0.9 * 0.5) < 0.05'
expect "query --error" 0 "$ist" query "$cube" "$cube" --pose 0.2,0.1,0.5,0,0,0,1 --error 0.3 --json
holds "query --error" 'r["level"] > 0 and r["kept"] is True and 0 < r["promise"] <= 0.3 and abs(r["volume"] - 0.8 * 0.9 * 0.5) < 0.05'
expect "query --error out of reach" 0 "$ist" query "$cube" "$cube" --pose 0.2,0.1,0.5,0,0,0,1 --error 0.0001 --json
holds "query --error out of reach" 'r["level"] == 0 and r["kept"] is False and r["promise"] > 0.0001'
expect "query --error of another law" 1 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 --error 0.3 --law energy --json
holds "query --error of another law" 'r["error"].startswith("unsupported")'
expect "query --error 2" 2 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 --error 2
expect "query --blend without a budget" 1 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 --blend --json
holds "query --blend without a budget" 'r["error"].startswith("unsupported")'
expect "query --max-pairs of another law" 1 "$ist" query "$cube" "$cube" --pose 0,0,0.9,0,0,0,1 --max-pairs 400 --law paper --json
holds "query --max-pairs of another law" 'r["error"].startswith("unsupported")'
expect "query, wrong pose" 1 "$ist" query "$cube" "$cube" --pose 0,0,1,0,0,0,2 --json
holds "query, wrong pose" 'r["row"] == 0 and "quaternion" in r["error"]'
expect "query, no pose" 2 "$ist" query "$cube" "$cube"
expect "query, missing asset" 1 "$ist" query "$cube" "$dir/none.ist" --pose 0,0,1,0,0,0,1

{
	printf '# poses\nname,qw,qx,qy,qz,tx,ty,tz\n'
	printf 'a,1,0,0,0,0,0,0.9\nb,1,0,0,0,zero,0,0.9\n# more\nc,1.0005,0,0,0,0,0,5\nd,1,0,0\n'
} > "$dir/poses.csv"
expect "query batch" 1 "$ist" query "$cube" "$cube" --poses "$dir/poses.csv" --threads 2 --repeat 2 --shuffle --json
holds "query batch" '[x["row"] for x in rows] == [0, 1, 2, 3] and rows[0]["volume"] > 0' \
	'and "error" in rows[1] and rows[2]["distance"] > 3.9 and "error" in rows[3]'
printf 'tx,ty\n0,0\n' > "$dir/bad.csv"
expect "query, missing column" 1 "$ist" query "$cube" "$cube" --poses "$dir/bad.csv"

head -c 1000 "$cube" > "$dir/cut.ist"
expect "cut asset" 1 "$ist" info "$dir/cut.ist"
says "cut asset" "cut short"
python3 -c "
data = bytearray(open('$cube', 'rb').read())
data[len(data) // 2] ^= 4
open('$dir/flip.ist', 'wb').write(data)
data[8] = 9
open('$dir/newer.ist', 'wb').write(data)
data[8] = 6
open('$dir/older.ist', 'wb').write(data)"
expect "damaged asset" 1 "$ist" check "$dir/flip.ist" --json
holds "damaged asset" 'r["ok"] is False and "checksum" in r["problems"][0]'
expect "newer asset" 1 "$ist" info "$dir/newer.ist"
says "newer asset" "newer version (9)"
expect "older asset" 1 "$ist" info "$dir/older.ist"
says "older asset" "is of format version 6 of BulletHaptics 0.3 or older; rebuild it: ist build MESH -o FILE"

[ "$failures" -eq 0 ] && echo "all passed"
exit $((failures > 0))
