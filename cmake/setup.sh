#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Installs the Debian packages that are missing: as root directly, else with sudo after saying what it will run.
# Usage: cmake/setup.sh [core|library|demos|tests|release|windows|windows-quick|arm] [--yes]
#   core      for the libraries and commands that need no Bullet (BULLETHAPTICS_BULLET=OFF)
#   library   for all libraries and commands
#   demos     for the demos, the drivers of devices and the Debian packages, too
#   tests     for all tests but those labelled "long", the Python module and the documentation, too (default)
#   release   for the tests labelled "long", too, as far as Debian has what they need
#   windows   for the libraries, commands and tests for Windows (preset windows-mingw) alone. It also builds Bullet,
#             assimp and GoogleTest for Windows, from Debian's sources, into ~/.cache/bullethaptics/windows (half an hour, once)
#   windows-quick   for the preset windows-quick alone, with Bullet in single precision and GoogleTest
#   arm       for the libraries, commands and tests for 64-bit ARM (tests/compilers/arm64.sh) alone
#   --yes     do not ask
set -euo pipefail

scope=tests yes=
for argument in "$@"; do
	case $argument in
	core | library | demos | tests | release | windows | windows-quick | arm) scope=$argument ;;
	--yes) yes=1 ;;
	*)
		echo "setup.sh: what is $argument? Known are core, library, demos, tests, release, windows, windows-quick, arm, --yes" >&2
		exit 2
		;;
	esac
done

packages=()
arm=(mmdebstrap g++-aarch64-linux-gnu qemu-user)
case $scope in # each brings what those below it need
release)
	packages+=("${arm[@]}" lintian g++-11 clang-16 clang-19 colcon python3-colcon-ros python3-colcon-cmake
		libignition-physics-core-dev libignition-physics-sdf-dev libignition-physics-mesh-dev libignition-physics5-bullet-plugin5
		libignition-plugin-dev)
	;&
tests)
	packages+=(locales clang clang-format-14 python3-dev python3-numpy pybind11-dev doxygen spacenavd xvfb xauth reuse abigail-tools)
	;&
demos)
	packages+=(glmark2-data libgtest-dev libgmock-dev python3 libboost-dev libopenxr-dev libsdl2-dev libspnav-dev libx11-dev
		libglfw3-dev libimgui-dev libstb-dev libopengl-dev libegl-dev libpng-dev libgl1-mesa-dri fonts-dejavu-core file dpkg-dev)
	;&
library)
	packages+=(libbullet-dev libbullet-extras-dev)
	;&
core)
	packages+=(g++ make cmake ninja-build ccache pkg-config libeigen3-dev libassimp-dev zlib1g-dev libcli11-dev nlohmann-json3-dev)
	;;
arm)
	packages+=("${arm[@]}" g++ make cmake ninja-build ccache pkg-config)
	;;
windows*)
	packages+=(g++-mingw-w64-x86-64-posix libz-mingw-w64-dev wine64 make cmake ninja-build ccache pkg-config dpkg-dev ca-certificates python3
		libeigen3-dev libcli11-dev nlohmann-json3-dev libboost-dev googletest libutfcpp-dev libstb-dev)
	;;
esac

# What Debian has for Linux only.
finish()
{
	case $scope in
	windows) bash "$(dirname "$0")/windows_dependencies.sh" ;;
	windows-quick) bash "$(dirname "$0")/windows_dependencies.sh" --quick ;;
	esac
}

missing=()
for package in "${packages[@]}"; do
	[ "$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null)" = "install ok installed" ] || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
	finish
	exit
fi

line="apt-get install --no-install-recommends -y ${missing[*]}"
if [ "$(id -u)" -eq 0 ]; then
	run=()
elif command -v sudo >/dev/null; then
	run=(sudo)
	echo "These packages are missing and will be installed with: sudo $line" >&2
	if [ -z "$yes" ]; then
		if [ ! -t 0 ]; then
			echo "Nobody is there to ask: run it yourself, or give --yes." >&2
			exit 1
		fi
		read -r -p "Go on? [y/N] " answer
		[ "$answer" = y ] || [ "$answer" = Y ] || exit 1
	fi
else
	echo "These packages are missing; ask an administrator to run: $line" >&2
	exit 1
fi
export DEBIAN_FRONTEND=noninteractive
"${run[@]}" apt-get update -qq >&2
"${run[@]}" $line >&2
finish
