# SPDX-License-Identifier: Zlib
# Builds the vcpkg port by vcpkg's own scripts, as the program vcpkg would call them, and uses the result.
# Debian's libraries take the place of vcpkg's. The program itself is not needed.
# Arguments: SOURCE (the project), WORK, LAUNCHER; in the environment VCPKG_ROOT, a checkout of github.com/microsoft/vcpkg.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/RunCommand.cmake)

set(VCPKG $ENV{VCPKG_ROOT})
if(NOT EXISTS ${VCPKG}/scripts/ports.cmake)
	message("skipped: no vcpkg (git clone https://github.com/microsoft/vcpkg, and VCPKG_ROOT its folder)")
	return()
endif()
file(REMOVE_RECURSE ${WORK})
# The libraries are static and have no paths to put right, for which vcpkg would download a program.
set(triplet ${WORK}/triplet.cmake)
file(WRITE ${triplet} "include(${VCPKG}/triplets/x64-linux.cmake)
set(VCPKG_BUILD_TYPE release)
set(VCPKG_FIXUP_ELF_RPATH OFF)
set(VCPKG_CMAKE_CONFIGURE_OPTIONS -DBulletPhysics_Double_LinearMath= -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
")
# What the helper ports would have installed.
set(helpers ${WORK}/helpers.cmake)
file(WRITE ${helpers} "include(${VCPKG}/ports/vcpkg-cmake/vcpkg-port-config.cmake)
include(${VCPKG}/ports/vcpkg-cmake-config/vcpkg-port-config.cmake)
")
set(ENV{VCPKG_FORCE_SYSTEM_BINARIES} 1)
run(${CMAKE_COMMAND} -DCMD=BUILD -DPORT=bullethaptics -DCURRENT_PORT_DIR=${SOURCE}/packaging/vcpkg/bullethaptics -DFEATURES=core
	-DTARGET_TRIPLET=x64-linux -DTARGET_TRIPLET_FILE=${triplet}
	-DZ_VCPKG_CHAINLOAD_TOOLCHAIN_FILE=${VCPKG}/scripts/toolchains/linux.cmake
	-D_HOST_TRIPLET=x64-linux -DVCPKG_PORT_CONFIGS=${helpers} -DVCPKG_ROOT_DIR=${VCPKG} -DDOWNLOADS=${WORK}/downloads
	-D_VCPKG_INSTALLED_DIR=${WORK}/installed -DVCPKG_BASE_VERSION=2025-01-01 -DVCPKG_CONCURRENCY=2
	-DCURRENT_BUILDTREES_DIR=${WORK}/build -DCURRENT_PACKAGES_DIR=${WORK}/package -DVERSION=0 -DGIT=git -P ${VCPKG}/scripts/ports.cmake)
foreach(file share/bullethaptics/copyright share/bullethaptics/BulletHapticsConfig.cmake lib/pkgconfig/bullethaptics-core.pc)
	if(NOT EXISTS ${WORK}/package/${file})
		message(FATAL_ERROR "the port left no ${file}")
	endif()
endforeach()
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer/find_package -B ${WORK}/consumer
	-DCMAKE_PREFIX_PATH=${WORK}/package -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK}/consumer --parallel 2)
run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK}/consumer --output-on-failure --no-tests=error)
message(STATUS "${text}")
