# SPDX-License-Identifier: Zlib
# Configures the project for a generator of several configurations. The programs of each must look for the importer program where the same
# configuration puts it.
# Arguments: SOURCE (the project), WORK.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/RunCommand.cmake)

find_program(ninja NAMES ninja ninja-build)
if(NOT ninja)
	message("skipped: no ninja")
	return()
endif()
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK} -G "Ninja Multi-Config" "-DCMAKE_CONFIGURATION_TYPES=Debug\;Release"
	-DBULLETHAPTICS_BULLET=OFF -DBULLETHAPTICS_PYTHON=OFF)
foreach(config Debug Release)
	set(source ${WORK}/generated/${config}/ImporterOfBuild.cpp)
	run(${ninja} -C ${WORK} -f build-${config}.ninja -t inputs BulletISTCollision/Tools/${config}/ist)
	if(NOT text MATCHES "${source}")
		message(FATAL_ERROR "ist of ${config} is not built with ${source}: ${text}")
	endif()
	file(READ ${source} content)
	if(NOT content MATCHES "path\\(([^()]*)\\)path")
		message(FATAL_ERROR "${source} names no program: ${content}")
	endif()
	file(RELATIVE_PATH importer ${WORK} ${CMAKE_MATCH_1})
	run(${ninja} -C ${WORK} -f build-${config}.ninja -t query ${importer})
	if(NOT text MATCHES "LINKER")
		message(FATAL_ERROR "nothing is linked as ${importer}: ${text}")
	endif()
endforeach()
