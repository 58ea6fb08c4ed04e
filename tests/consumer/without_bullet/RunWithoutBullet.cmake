# SPDX-License-Identifier: Zlib
# Configures the project without Bullet, as on a machine that has none, and looks at what is built: no target may name Bullet's headers
# or libraries. With BUILD it builds and installs all of that, and programs use it by the CMake package and by pkg-config.
# Arguments: SOURCE (the project), WORK, GENERATOR, LAUNCHER, INCLUDE (the folder of Bullet's headers), BUILD.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/../RunCommand.cmake)

# Fails if a line of these files matches.
function(refuse_lines regex what)
	if(NOT ARGN)
		message(FATAL_ERROR "no files to look at: ${what}")
	endif()
	foreach(file ${ARGN})
		file(STRINGS ${file} named REGEX "${regex}" LIMIT_COUNT 1)
		if(named)
			message(FATAL_ERROR "${file} ${what}: ${named}")
		endif()
	endforeach()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DBULLETHAPTICS_BULLET=OFF -DCMAKE_BUILD_TYPE=Release
	-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -DCMAKE_DISABLE_FIND_PACKAGE_BulletPhysics=ON)
file(GLOB_RECURSE lines ${WORK}/build/build.ninja ${WORK}/build/compile_commands.json ${WORK}/build/*link.txt ${WORK}/build/*flags.make)
refuse_lines("${INCLUDE}|(lib|-l)(LinearMath|BulletCollision|BulletDynamics)" "names Bullet" ${lines})
foreach(option DEMOS TESTS PRELOAD)
	execute_process(COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/refused -DBULLETHAPTICS_BULLET=OFF -DBULLETHAPTICS_${option}=ON
		RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE text)
	file(REMOVE_RECURSE ${WORK}/refused)
	if(code EQUAL 0 OR NOT text MATCHES "need Bullet")
		message(FATAL_ERROR "BULLETHAPTICS_${option} without Bullet is not refused: ${code}, ${text}")
	endif()
endforeach()
if(NOT BUILD)
	return()
endif()

run(${CMAKE_COMMAND} --build ${WORK}/build --parallel 2)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/prefix)
file(GLOB_RECURSE headers ${WORK}/prefix/include/*.h)
refuse_lines("#include.*(btBullet|LinearMath/|BulletCollision/|BulletDynamics/)" "is installed and needs Bullet" ${headers})
set(consumer ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/consumer -DCMAKE_BUILD_TYPE=Release
	-DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_DISABLE_FIND_PACKAGE_BulletPhysics=ON)
run(${consumer})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
foreach(program core devices core_by_pkg_config devices_by_pkg_config)
	run(${WORK}/consumer/${program})
endforeach()
execute_process(COMMAND ${consumer} "-DCOMPONENTS=Core\;HapticForce" RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE text)
string(REGEX REPLACE "[ \n]+" " " text "${text}")
if(code EQUAL 0 OR NOT text MATCHES "was built without HapticForce \\(BULLETHAPTICS_BULLET: OFF")
	message(FATAL_ERROR "a component that is not there is not refused: ${code}, ${text}")
endif()
run(${WORK}/prefix/bin/ist --version)
run(${WORK}/prefix/bin/devicebridge list)
