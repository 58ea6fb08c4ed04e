#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Every file has a licence whose text is in LICENSES, and a copyright. Usage: licences_test.sh SOURCE. Exit status 77: there is no reuse,
# or no checkout, without which builds would be looked at, too.
command -v reuse >/dev/null || {
	echo "skipped: no reuse (apt-get install reuse)"
	exit 77
}
cd "$1"
git rev-parse >/dev/null 2>&1 || {
	echo "skipped: no checkout of git"
	exit 77
}
exec reuse lint
