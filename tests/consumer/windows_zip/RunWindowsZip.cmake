# SPDX-License-Identifier: Zlib
# Builds DLLs and commands for Windows by mingw-w64, packs them in a zip, and uses them from where the zip was unpacked: the commands, and
# programs that find the CMake package and nothing else there. All run under Wine.
# Arguments: SOURCE (the project), WORK; BUILD, a build folder of its own when it is to be kept; LAUNCHER.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/../RunCommand.cmake)

set(root $ENV{HOME}/.cache/bullethaptics/windows/root)
find_program(compiler x86_64-w64-mingw32-g++-posix)
find_program(wine wine64 PATHS /usr/lib/wine)
find_program(objdump x86_64-w64-mingw32-objdump)
if(NOT compiler OR NOT wine OR NOT EXISTS ${root}/state/bullet-dll-double-ON OR NOT EXISTS ${root}/state/assimp)
	message("skipped: no mingw-w64, Wine, or Bullet and assimp for Windows (bash cmake/setup.sh windows)")
	return()
endif()
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
if(NOT BUILD)
	set(BUILD ${WORK}/build)
endif()
set(ENV{WINEDEBUG} -all)
set(ENV{WINEPREFIX} ${WORK}/wine)

execute_process(COMMAND ${CMAKE_COMMAND} --preset windows-dll -B ${BUILD} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
	WORKING_DIRECTORY ${SOURCE} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
run(${CMAKE_COMMAND} --build ${BUILD} --parallel 2)
cmake_path(GET CMAKE_COMMAND PARENT_PATH programs)
find_program(cpack cpack HINTS ${programs} REQUIRED)
run(${cpack} --config ${BUILD}/CPackConfig.cmake)
file(GLOB zip ${BUILD}/BulletHaptics-*.zip)
list(LENGTH zip count)
if(NOT count EQUAL 1)
	message(FATAL_ERROR "one zip was expected in ${BUILD}: ${zip}")
endif()
# A name that needs quotes, and letters that no code page has all of.
file(ARCHIVE_EXTRACT INPUT ${zip} DESTINATION "${WORK}/unpacked here")
file(GLOB folder "${WORK}/unpacked here/*")

# Hidden names stay hidden.
file(GLOB libraries ${folder}/bin/libistcore.dll ${folder}/bin/libBullet[IH]*.dll ${folder}/bin/libDeviceBridge*.dll)
if(NOT libraries)
	message(FATAL_ERROR "no DLLs in ${folder}/bin")
endif()
run(python3 ${SOURCE}/packaging/exported_symbols.py ${libraries})

# The commands need nothing but what the zip has. On Windows, an argument that begins with / is an option.
run(${wine} ${folder}/bin/ist.exe --version)
message(STATUS "${text}")
file(WRITE ${WORK}/box.obj "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
run(${wine} ${folder}/bin/ist.exe build Z:${WORK}/box.obj -o Z:${WORK}/box.ist --spheres 200)
run(${wine} ${folder}/bin/ist.exe check Z:${WORK}/box.ist)
run(${wine} ${folder}/bin/devicebridge.exe list)
message(STATUS "${text}")
# Each plug-in names the vendor's library that it misses.
if(NOT text MATCHES "dhd64\\.dll" OR NOT text MATCHES "virtuoseAPI\\.dll")
	message(FATAL_ERROR "the plug-ins of the zip are not found:\n${text}")
endif()

# Wine takes Windows' names of folders; where programs run on Windows, the DLLs lie beside them.
set(ENV{WINEPATH} "Z:${folder}/bin")
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer/find_package -B ${WORK}/consumer -DBUILD_SHARED_LIBS=ON
	-DCMAKE_TOOLCHAIN_FILE=${SOURCE}/cmake/x86_64-w64-mingw32.cmake -DBULLETHAPTICS_WINDOWS_ROOT=${folder} -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK}/consumer --parallel 2)
run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK}/consumer --output-on-failure --no-tests=error)
message(STATUS "${text}")
