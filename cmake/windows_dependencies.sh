#!/usr/bin/env bash
# SPDX-License-Identifier: Zlib
# Builds for Windows what Debian has for Linux only: Bullet in both precisions, assimp and GoogleTest, from Debian's own sources, and puts
# links beside them to headers that are the same on every system. Half an hour on two cores, once.
# Usage: cmake/windows_dependencies.sh [--quick] [FOLDER]
#   --quick  only what the preset windows-quick needs: GoogleTest, and Bullet in single precision (some minutes)
#   FOLDER   for sources, builds, and the result in FOLDER/root; by default ~/.cache/bullethaptics/windows
# cmake/setup.sh windows and cmake/setup.sh windows-quick call it.
set -euo pipefail
quick=
if [ "${1:-}" = --quick ]; then
	quick=1
	shift
fi
source=$(cd "$(dirname "$0")" && pwd)
folder=${1:-$HOME/.cache/bullethaptics/windows}
root=$folder/root
toolchain=$source/x86_64-w64-mingw32.cmake

# What was built is kept until its options, the toolchain file or the compiler change.
state=$(cat "$toolchain"; x86_64-w64-mingw32-g++-posix --version | head -1)
mkdir -p "$folder/sources" "$folder/apt/parts" "$folder/apt/lists/partial" "$root/include" "$root/share/cmake" "$root/state"

# A list of sources of its own: the system's stays as it is.
apt=(-o Dir::Etc::sourcelist=/dev/null -o "Dir::Etc::sourceparts=$folder/apt/parts" -o "Dir::State::Lists=$folder/apt/lists" -qq
	-o APT::Sandbox::User=root)
sed 's/^Types: .*/Types: deb-src/' /etc/apt/sources.list.d/debian.sources >"$folder/apt/parts/sources.sources"

launcher=()
! command -v ccache >/dev/null || launcher=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)

# quiet COMMAND...: what it says is shown where it fails.
quiet() { "$@" >"$folder/log.txt" 2>&1 || { tail -n 60 "$folder/log.txt" >&2; return 1; }; }

# unpack PACKAGE: its patched source is in $folder/sources/PACKAGE.
unpack()
{
	[ ! -d "$folder/sources/$1" ] || return 0
	[ -n "${updated:-}" ] || quiet apt-get "${apt[@]}" update
	updated=1
	(cd "$folder/sources" && quiet apt-get "${apt[@]}" source --download-only "$1")
	quiet dpkg-source --no-check -x "$folder/sources/$1"_*.dsc "$folder/sources/$1.new"
	mv "$folder/sources/$1.new" "$folder/sources/$1"
}

# build NAME SOURCE OPTION...: configures, builds and installs into $root.
build()
{
	local name=$1 from=$2
	shift 2
	[ "$(cat "$root/state/$name" 2>/dev/null)" != "$state $*" ] || return 0
	echo "Building $name for Windows" >&2
	rm -rf "$folder/build/$name"
	quiet cmake -S "$from" -B "$folder/build/$name" -G Ninja -DCMAKE_BUILD_TYPE=Release "${launcher[@]}" -DCMAKE_TOOLCHAIN_FILE="$toolchain" \
		-DBULLETHAPTICS_WINDOWS_ROOT="$root" -DCMAKE_INSTALL_PREFIX="$root" -DBUILD_SHARED_LIBS=OFF -Wno-dev "$@"
	quiet cmake --build "$folder/build/$name"
	quiet cmake --install "$folder/build/$name"
	rm -rf "$folder/build/$name"
	echo "$state $*" >"$root/state/$name"
}

# Headers without a compiled part. Links, because /usr/include itself must not be searched.
for header in nlohmann CLI boost eigen3 openxr stb utf8 utf8.h; do
	[ ! -e /usr/include/$header ] || ln -sfn /usr/include/$header "$root/include/$header"
done
for package in nlohmann_json CLI11; do cp -rT /usr/share/cmake/$package "$root/share/cmake/$package"; done
mkdir -p "$root/share/eigen3"
cp -rT /usr/share/eigen3/cmake "$root/share/eigen3/cmake"

# Licences of what a zip for Windows takes along.
mkdir -p "$root/share/notices"
notice() { cp "$1" "$root/share/notices/$2.txt"; }
for package in gcc-mingw-w64-base mingw-w64-common libz-mingw-w64; do
	notice /usr/share/doc/$package/copyright $package
done

build googletest /usr/src/googletest

unpack bullet
notice "$folder/sources/bullet/debian/copyright" bullet
# Its reader of XML needs a library that nothing here needs.
sed -i 's/BulletXmlWorldImporter//' "$folder/sources/bullet/Extras/Serialize/CMakeLists.txt"
for double in OFF ON; do
	[ -z "$quick" ] || [ $double = OFF ] || continue
	build bullet-double-$double "$folder/sources/bullet" -DUSE_DOUBLE_PRECISION=$double -DBUILD_EXTRAS=ON -DINSTALL_LIBS=ON \
		-DINSTALL_EXTRA_LIBS=ON -DBUILD_BULLET2_DEMOS=OFF -DBUILD_OPENGL3_DEMOS=OFF -DBUILD_CPU_DEMOS=OFF -DBUILD_UNIT_TESTS=OFF \
		-DBUILD_BULLET_ROBOTICS_GUI_EXTRA=OFF -DBUILD_BULLET_ROBOTICS_EXTRA=OFF -DBUILD_OBJ2SDF_EXTRA=OFF -DBUILD_BULLET3=OFF \
		-DBUILD_INVERSE_DYNAMIC_EXTRA=OFF -DBUILD_PYBULLET=OFF -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON -DCMAKE_CXX_FLAGS=-w
	[ -z "$quick" ] || continue
	# As DLLs in a folder of their own, which BULLET_ROOT names: shared libraries of ours and a game share one Bullet.
	build bullet-dll-double-$double "$folder/sources/bullet" -DUSE_DOUBLE_PRECISION=$double -DBUILD_EXTRAS=OFF -DINSTALL_LIBS=ON \
		-DBUILD_BULLET2_DEMOS=OFF -DBUILD_OPENGL3_DEMOS=OFF -DBUILD_CPU_DEMOS=OFF -DBUILD_UNIT_TESTS=OFF -DBUILD_BULLET3=OFF \
		-DBUILD_PYBULLET=OFF -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON -DCMAKE_CXX_FLAGS=-w \
		-DBUILD_SHARED_LIBS=ON -DCMAKE_INSTALL_PREFIX="$root/dll"
done

[ -z "$quick" ] || exit 0

# Assimp's build looks for minizip by pkg-config.
unpack minizip
notice "$folder/sources/minizip/debian/copyright" minizip
compiler=x86_64-w64-mingw32-gcc-posix
for file in unzip ioapi; do
	quiet $compiler -O2 -w -DUSE_FILE32API -DIOAPI_NO_64 -c "$folder/sources/minizip/$file.c" -o "$folder/$file.o"
done
x86_64-w64-mingw32-ar rcs "$root/lib/libminizip.a" "$folder/unzip.o" "$folder/ioapi.o"
mkdir -p "$root/include/minizip" "$root/lib/pkgconfig"
cp "$folder"/sources/minizip/{unzip,ioapi}.h "$root/include/minizip/"
printf 'Name: minizip\nDescription: reads archives\nVersion: 1.1\nLibs: -L%s -lminizip -lz\nCflags: -I%s\n' \
	"$root/lib" "$root/include/minizip" >"$root/lib/pkgconfig/minizip.pc"
unpack assimp
notice "$folder/sources/assimp/debian/copyright" assimp
# Without draco, a compression of glTF, which Debian links unconditionally. Without the writers of files and the reader of IFC (buildings),
# which take a third of the time to compile.
sed -i '/^find_package(draco CONFIG REQUIRED)/d; /^target_link_libraries(assimp ${DRACO_LIBRARIES})/d' \
	"$folder/sources/assimp/code/CMakeLists.txt"
PKG_CONFIG_LIBDIR=$root/lib/pkgconfig build assimp "$folder/sources/assimp" -DASSIMP_BUILD_ASSIMP_TOOLS=OFF -DASSIMP_BUILD_TESTS=OFF \
	-DASSIMP_NO_EXPORT=ON -DASSIMP_BUILD_IFC_IMPORTER=OFF -DASSIMP_INSTALL_PDB=OFF -DASSIMP_WARNINGS_AS_ERRORS=OFF \
	-DCMAKE_CXX_FLAGS="-Wa,-mbig-obj -w -I$root/include" -DCMAKE_C_FLAGS=-w
# Debian's package file asks for draco, too, and names minizip without its folder.
sed -i '/draco/d' "$root"/lib/cmake/assimp-*/assimpConfig.cmake
sed -i 's#;minizip;#;${_IMPORT_PREFIX}/lib/libminizip.a;#' "$root"/lib/cmake/assimp-*/assimpTargets.cmake
