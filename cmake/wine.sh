#!/bin/sh
# SPDX-License-Identifier: Zlib
# Runs a program under Wine: wine.sh WINE PROGRAM [ARGUMENT...]
# Services and consoles of Wine outlive the program that began them. They would hold its output open, and ctest would wait for the end of
# that; so the output goes into a file first.
output=$(mktemp) || exit 1
trap 'rm -f "$output"' EXIT
"$@" > "$output" 2>&1 < /dev/null
status=$?
cat "$output"
exit $status
