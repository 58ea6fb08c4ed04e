#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Makes the smallest Debian that the package sources of this system give, and has apt install our packages there with their dependencies.
# Then it uses them from inside: the commands, the Python module, and a program as a user would write it.
# It runs as root, because it changes into that system (chroot). The system takes 1.5 GB for a while.
# Usage: bare_system.sh SOURCE FOLDER_WITH_PACKAGES WORK
# Exit status 77: something that this needs is missing, with the line that brings it.
set -euo pipefail
source=$1 packages=$2 root=$3/root
sources=/etc/apt/sources.list.d/debian.sources
[ -e "$sources" ] || sources=/etc/apt/sources.list

skip()
{
	echo "skipped: $1"
	exit 77
}
command -v mmdebstrap >/dev/null || skip "no mmdebstrap (apt-get install mmdebstrap)"
[ "$(id -u)" = 0 ] || skip "not root (sudo ctest ...)"
[ -s "$sources" ] || skip "no package sources in /etc/apt"
compgen -G "$packages/libbullethaptics-dev_*.deb" >/dev/null || skip "no packages (ctest -L long -R consumer_packages makes them)"

inside()
{
	echo "+ $*"
	chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}

apt() { inside apt-get -qq -o Dpkg::Use-Pty=0 --no-install-recommends "$@" >/dev/null; }

# The file of a package, as it is called inside. A pattern may stand for the name.
file_of() { (cd "$root" && printf '/%s' packages/$1_*.deb); }

# Alone beside the library, and gone again afterwards: no package gets from another what it should have asked for itself.
try()
{
	local package=$1
	apt install "$(file_of 'libbullethaptics[0-9]*')" "$(file_of "$package")"
	shift
	for command in "$@"; do inside sh -c "$command"; done
	apt --autoremove purge "$package"
}

rm -rf "$root"
mkdir -p "$root"
mmdebstrap --quiet --variant=apt "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$root" "$sources"
mkdir "$root/packages" "$root/consumer"
cp "$packages"/*.deb "$root/packages"
cp "$source"/tests/consumer/find_package/* "$root/consumer"
apt update

try bullethaptics-tools 'ist --version' 'devicebridge list'
try bullethaptics-demos 'haptic_demos --list' 'haptic_demos --demo heavy-on-light --headless'
if compgen -G "$packages/python3-bullethaptics_*.deb" >/dev/null; then
	try python3-bullethaptics 'python3 -c "import bullethaptics; print(bullethaptics.__version__)"'
fi
apt install "$(file_of 'libbullethaptics[0-9]*')" "$(file_of libbullethaptics-dev)" cmake g++ make libgmock-dev glmark2-data
inside cmake -S /consumer -B /consumer/build -DCMAKE_BUILD_TYPE=Release
inside cmake --build /consumer/build --parallel 2
inside ctest --test-dir /consumer/build --output-on-failure --no-tests=error
rm -rf "$root"
