#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Usage: devicebridge_command_test.sh PATH_TO_DEVICEBRIDGE FOLDER_OF_PROFILES. Exit code 0 when every expectation holds.
set -u
bridge=$1
profiles=$2
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

# holds NAME EXPRESSION...: Python over `r`, the JSON object of the last output.
# Several arguments are one expression, joined by spaces.
holds()
{
	if ! python3 - "$dir/out" "${*:2}" <<'PYTHON'
import json, sys
r = json.load(open(sys.argv[1]))
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
		echo "FAILED $1: stderr lacks '$2'"
		cat "$dir/err"
		failures=$((failures + 1))
	fi
}

expect "no command" 2 "$bridge"
expect "help" 0 "$bridge" --help
expect "version" 0 "$bridge" --version
expect "list as text" 0 "$bridge" list
grep -q '^  plugin:  *no libdevicebridge_NAME.so' "$dir/out" || { echo "FAILED list says what is missing"; failures=$((failures + 1)); }
[ "$(sed -n '/^drivers/,/^missing/p' "$dir/out" | wc -L)" -le 110 ] || { echo "FAILED list is too wide"; failures=$((failures + 1)); }
grep -q '^  sim:touchx  *3D Systems  *Touch X$' "$dir/out" || { echo "FAILED list as text"; failures=$((failures + 1)); }
expect "unknown command" 2 "$bridge" lits
grep -q 'the nearest is "list"' "$dir/err" || { echo "FAILED unknown command"; failures=$((failures + 1)); }
expect "list" 0 "$bridge" list --json
holds "list" 'r["schema"] == 1 and {"sim:", "replay:"} <= {d["scheme"] for d in r["drivers"]} and len(r["devices"]) >= 15'
expect "state of two" 0 "$bridge" state sim:touchx sim:sigma7 --seconds 0.2 --json
holds "state of two" '[d["state"] for d in r["devices"]] == ["ready", "ready"] and r["devices"][1]["model"] == "sigma.7"' \
	'and r["devices"][0]["samples_hz"] > 0 and r["devices"][0]["buttons"] == "none"'
expect "state as a table" 0 "$bridge" state sim:touchx --seconds 0.1
grep -q '^  sim:touchx  *ready  *Touch X ' "$dir/out" || { echo "FAILED state as a table"; cat "$dir/out"; failures=$((failures + 1)); }
expect "state of none" 1 "$bridge" state sim:nothing sim:touchx --seconds 0.1 --json
holds "state of none" '"No simulated device is called" in r["devices"][0]["state"] and r["devices"][1]["state"] == "ready"'
expect "state of a pose that is not finite" 1 "$bridge" state 'sim:touch?fault=nan' --seconds 0.1 --json
holds "state of a pose that is not finite" '"not finite" in r["devices"][0]["state"]'
expect "a device that is lost while it is watched" 0 "$bridge" record sim:touchx --seconds 0.3 -o "$dir/short.istdrec"
expect "a device that is lost while it is watched" 1 "$bridge" state "replay:$dir/short.istdrec" --watch --seconds 1
[ "$(grep -c "replay:$dir/short.istdrec  " "$dir/out")" -eq 2 ] && grep -q ' ready$' "$dir/out" && grep -q ' lost: ' "$dir/out" \
	|| { echo "FAILED a device that is lost while it is watched"; cat "$dir/out"; failures=$((failures + 1)); }
rm -f "$dir/later.istdrec"
(sleep 1; cp "$dir/short.istdrec" "$dir/later.istdrec") &
expect "a device that comes while it is watched" 1 "$bridge" state "replay:$dir/later.istdrec" --watch --seconds 3
wait
grep -q "later.istdrec\": opening the file failed" "$dir/out" && grep -q "later.istdrec  \(ready\|lost\)" "$dir/out" ||
	{ echo "FAILED a device that comes while it is watched"; cat "$dir/out"; failures=$((failures + 1)); }
expect "info" 0 "$bridge" info sim:touchx --json
holds "info" 'r["peak_force"] == 7.9 and r["peak_torque"] is None and r["handedness"] == "either"' \
	'and "peakForce: " in r["source"] and r["actuated"] == ["x", "y", "z"]'
holds "info says what is assumed" 'r["damping"] == 0.5 and r["assumed"] == [] and r["profile"] is None'
expect "info of an unknown device" 1 "$bridge" info sim:nothing
says "unknown device" "sigma7"
expect "info without a scheme" 1 "$bridge" info sigma7

sed 's/"peakForce": {"value": [0-9.]*/"peakForce": {"value": "much"/' "$profiles/touchx.json" > "$dir/bad.json"
expect "damaged profile" 1 "$bridge" info "sim:$dir/bad.json"
says "damaged profile" "line 7, field peakForce"
expect "own profile" 0 "$bridge" info "sim:$profiles/omega6.json" --json
holds "own profile" 'r["model"] == "omega.6"'

for device in sim:sigma7 sim:touch sim:virtuose6d; do
	expect "record $device" 0 "$bridge" record $device -o "$dir/run.istdrec" --seconds 2 --json
	holds "record $device" 'r["ticks"] == 2000 and r["faults"] == 0'
	expect "replay $device" 0 "$bridge" replay "$dir/run.istdrec" --json
	holds "replay $device" 'r["ok"] and r["mismatches"] == 0 and r["ticks"] == 2000'
	expect "replay against another wall" 1 "$bridge" replay "$dir/run.istdrec" --stiffness 12 --json
	holds "replay against another wall" 'not r["ok"] and r["first_mismatch"] > 600'
	expect "self test $device" 0 "$bridge" selftest $device --json
	holds "self test $device" 'r["ok"] and len(r["checks"]) >= 4'
done
head -c 5000 "$dir/run.istdrec" > "$dir/cut.istdrec"
expect "cut recording" 1 "$bridge" replay "$dir/cut.istdrec"
says "cut recording" "checksum"
expect "recording into nowhere" 1 "$bridge" record sim:touch -o "$dir/no/such/folder/run" --seconds 0.1

expect "zwidth" 0 "$bridge" zwidth sim:sigma7 --steps 3 --json
holds "zwidth" 'all(abs(p["stable"] / p["predicted"] - 1) < 0.05 for p in r["points"]) and len(r["points"]) == 3'
expect "zwidth in steps" 0 "$bridge" zwidth sim:sigma7 --steps 3 --quantised --delay-ticks 2 --json
holds "zwidth in steps" 'r["resolution"] == 1.5e-06 and all(p["passive_measured"] <= p["stable"] for p in r["points"])'
for option in steps delay-ticks; do
	expect "zwidth --$option 0x2" 2 "$bridge" zwidth "--$option" 0x2
	says "zwidth --$option 0x2" "whole number from"
done
expect "zwidth of a recording" 1 "$bridge" zwidth replay:x
expect "monitor" 0 "$bridge" monitor sim:touch --seconds 1 --rate 10
[ "$(wc -l < "$dir/out")" -eq 11 ] || { echo "FAILED monitor: $(wc -l < "$dir/out") lines"; failures=$((failures + 1)); }

# A glove on a pseudo terminal, flat and then a fist, is calibrated and read with its calibration.
expect "calibrate" 0 python3 "$(dirname "$0")/glove_calibration_test.py" "$bridge" "$dir/glove.json"
expect "calibrate what is no glove" 1 "$bridge" calibrate sim:touch -o "$dir/x.json"

# An acceptance: the simulated hand moves, the answers are these. Arguments: the six pushes, the ruler, the release.
answers()
{
	printf '%s\n' yes "" "" "" "" "" "" ""  "" "" "" "" "" "" ""  "" "$2"  ""
	for felt in $1; do printf '\n%s\n' "$felt"; done
	printf '%s\n' "" "$3"  "" ""  "All as Described."
}
felt="right left up down towards away"
# accept NAME WANTED_CODE ANSWERS ADDRESS [OPTION...]: the file is what `holds` looks at then.
accept()
{
	local name=$1 wanted=$2 given=$3 address=$4
	shift 4
	rm -f "$dir/accepted.json"
	expect "$name" "$wanted" timeout 60 "$bridge" acceptance "$address" -o "$dir/accepted.json" "$@" < <(printf '%s\n' "$given")
	if [ -e "$dir/accepted.json" ]; then cp "$dir/accepted.json" "$dir/out"; else echo '{"parts": [], "file": null}' > "$dir/out"; fi
}
part='{p["part"]: p for p in r["parts"]}'
accept "acceptance" 0 "$(answers "$felt" 40 yes)" sim:sigma7
says "acceptance of a simulated device tells what to answer" "40 (mm), and right, left, up, down, towards, away"
holds "acceptance" 'r["ok"] and r["complete"] and r["simulated"]'
holds "acceptance says whose it is" 'r["comment"] == "All as Described." and r["device"]["model"] == "sigma.7"'
holds "acceptance has its parts" '[p["part"] for p in r["parts"]] == ["axes", "turns", "scale", "rate", "forces", "release", "unplug"]'
holds "a push is at most 1 N and gets there" \
	"all(0.99 < q['strongest_n'] <= 1 and abs(q['moved_m'] - 1 / 300) < 4e-4 for q in $part['forces']['pushes'])"
holds "a handle that is let go is not pushed on" \
	"(lambda p: p['guarded'] and p['after_guard_n'] < 1e-3 and p['fastest_m_s'] > 0.3)($part['release'])"
holds "the loss has a cause" "$part['unplug']['cause'] == 'the device does not answer' and $part['unplug']['back']"
accept "an acceptance of a scaled device" 0 "$(answers "$felt" 40 yes)" 'sim:touchx?scale=2'
holds "lengths and forces are those at the handle" \
	"abs($part['scale']['device_m'] - 0.08) < 1e-4 and all(0.99 < q['strongest_n'] <= 1 for q in $part['forces']['pushes'])"
accept "a push to the wrong side" 1 "$(answers "left left up down towards away" 40 yes)" sim:sigma7
holds "a push to the wrong side" "not r['ok'] and [q['ok'] for q in $part['forces']['pushes']] == [False] + 5 * [True]"
accept "a wrong scale" 1 "$(answers "$felt" 44 yes)" sim:sigma7
holds "a wrong scale" "[p['part'] for p in r['parts'] if not p['ok']] == ['scale']"
accept "a ruler and a word" 0 "$(answers "$felt" "$(printf '40 mm\nforty\n40')" yes)" sim:sigma7
says "a ruler and a word" "A number of millimetres alone"
accept "axes that are unknown" 1 "$(printf '%s\n' yes skip skip skip skip skip "")" "replay:$dir/short.istdrec"
holds "axes that are unknown" "all('axes first' in $part[name]['error'] for name in ('turns', 'forces'))"
accept "a handle that runs away" 1 "$(answers "$felt" 40 no)" sim:sigma7
holds "a handle that runs away" "[p['part'] for p in r['parts'] if not p['ok']] == ['release']"
accept "no answer to the first question" 1 "no" sim:sigma7
holds "nothing was written" 'r["file"] is None'
accept "an acceptance that is left" 1 "$(answers "$felt" 40 yes | head -20)" sim:sigma7
says "an acceptance that is left" "no file was written"
holds "an acceptance that is left" 'r["file"] is None'
accept "parts can be left out" 0 "$(printf '%s\n' yes skip skip skip skip skip skip skip "")" sim:sigma7
holds "parts can be left out" 'r["ok"] and not r["complete"] and all(p["skipped"] for p in r["parts"])'
accept "an acceptance without forces" 0 "$(answers "" 40 yes | sed '/^yes$/{1!d}')" sim:sigma7 --without-forces
holds "an acceptance without forces" '"forces" not in '"$part"' and r["ok"] and not r["complete"]'
accept "a device with a fault" 1 "$(printf '%s\n' yes "" skip skip skip skip skip skip "")" 'sim:touchx?fault=nan'
holds "a device with a fault" "'not finite' in $part['axes']['error']"
expect "an acceptance into nowhere" 1 "$bridge" acceptance sim:sigma7 -o "$dir/no/such/folder/a.json" < /dev/null

# A hand is recorded, played by address, and recorded again: the same file.
python3 - "$dir/in.csv" <<'PYTHON'
import sys
joints = ["palm", "wrist"] + ["thumb_" + j for j in ("metacarpal", "proximal", "distal", "tip")]
joints += [f + "_" + j for f in ("index", "middle", "ring", "little") for j in ("metacarpal", "proximal", "intermediate", "distal", "tip")]
fields = ["x", "y", "z", "qx", "qy", "qz", "qw", "r"]
with open(sys.argv[1], "w") as out:
    print("time,left," + ",".join(j + "_" + f for j in joints for f in fields), file=out)
    for t, tracked in ((0, True), (0.04, True), (0.07, True), (0.09, False), (0.13, True)):
        row = [f"{1.3 * t + 0.01 * i},{0.1 + t},{-t},0,0.6,0,0.8,0.008" if tracked or i % 3 else ",,,,,,," for i in range(26)]
        print(f"{t},1," + ",".join(row), file=out)
PYTHON
accept "forces of what has no motors" 1 "$(answers "$felt" 40 yes)" "motion:$dir/in.csv"
says "forces of what has no motors" "--without-forces walks through the rest"
expect "record a hand" 0 "$bridge" record "motion:$dir/in.csv" -o "$dir/hand.istdrec" --hand "$dir/a.csv" --seconds 0.2 --json
holds "record a hand" 'r["hand_frames"] > 80'
expect "record it again" 0 "$bridge" record "motion:$dir/a.csv" -o "$dir/hand.istdrec" --hand "$dir/b.csv" --seconds 0.2
cmp "$dir/a.csv" "$dir/b.csv" || { echo "FAILED a hand recorded twice"; failures=$((failures + 1)); }
expect "record both into one file" 1 "$bridge" record "motion:$dir/in.csv" -o "$dir/both.csv" --hand "$dir/./both.csv" --seconds 0.1
says "record both into one file" "name two files"
expect "record the hand of a device without one" 1 "$bridge" record sim:touch -o "$dir/x.istdrec" --hand "$dir/x.csv" --seconds 0.1
says "record the hand of a device without one" "senses no joints"

# A signal ends a run in real time early, and what was recorded until then is whole.
"$bridge" record sim:sigma7 -o "$dir/live.istdrec" --seconds 600 --real-time > "$dir/out" 2> "$dir/err" &
pid=$!
sleep 1
kill -TERM $pid
wait $pid
code=$?
[ "$code" -eq 130 ] || { echo "FAILED signal: exit $code"; failures=$((failures + 1)); }
expect "info of a recording" 0 "$bridge" info "replay:$dir/live.istdrec" --json
holds "info of a recording" 'r["model"] == "sigma.7"'

[ "$failures" -eq 0 ] && echo "all expectations hold"
exit $((failures > 0))
