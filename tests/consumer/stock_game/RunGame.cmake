# SPDX-License-Identifier: Zlib
# Builds the game without and with our lines and compares their motion. SOURCE, WORK, WAY; LAUNCHER; and one of BUILD, which is installed, PREFIX, where the
# library is installed, and BULLETHAPTICS_SOURCE.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/../RunCommand.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/CompareGame.cmake)

file(REMOVE_RECURSE ${WORK})
if(BUILD)
	set(PREFIX ${WORK}/prefix)
	run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX})
endif()
if(PREFIX)
	file(GLOB_RECURSE packages ${PREFIX}/*.pc)
	list(GET packages 0 package)
	cmake_path(GET package PARENT_PATH folder)
	set(ENV{PKG_CONFIG_PATH} ${folder})
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -DWAY=${WAY} -DCMAKE_PREFIX_PATH=${PREFIX} -DCMAKE_BUILD_TYPE=Release
	-DBULLETHAPTICS_SOURCE=${BULLETHAPTICS_SOURCE} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
run(${CMAKE_COMMAND} --build ${WORK}/build --parallel 2)
foreach(precision "" "-float64")
	compareGame(${WORK}/build "${precision}")
	if(WAY STREQUAL "pkg_config")
		run(${WORK}/build/bridge${precision})
	endif()
endforeach()
if(WAY STREQUAL "pkg_config")
	run(${WORK}/build/devices)
	message(STATUS "${text}")
endif()
