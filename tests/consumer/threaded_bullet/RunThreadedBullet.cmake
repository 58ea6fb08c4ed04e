# SPDX-License-Identifier: Zlib
# The stock game, and worlds with threads, with a Bullet that was built for threads, by each way into the library.
# Arguments: BULLET, where that Bullet is, one folder for each precision; SOURCE (the project), WORK, GENERATOR, LAUNCHER.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/../RunCommand.cmake)

if(NOT BULLET)
	message("skipped: no Bullet with threads; say in BULLETHAPTICS_THREADED_BULLET where one was installed, built with BULLET2_MULTITHREADING")
	return()
endif()
string(REPLACE ";" "\\;" bullet "${BULLET}")
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/library -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
	-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} "-DBULLET_ROOT=${bullet}"
	-DBULLETHAPTICS_DEMOS=OFF -DBULLETHAPTICS_TESTS=OFF -DBULLETHAPTICS_PYTHON=OFF)
run(${CMAKE_COMMAND} --build ${WORK}/library --parallel 2)
run(${CMAKE_COMMAND} --install ${WORK}/library --prefix ${WORK}/prefix)

# Which folder has which precision, the library's build has found out.
set(precisions "")
foreach(precision Single Double)
	file(STRINGS ${WORK}/library/CMakeCache.txt found REGEX "^BulletPhysics_${precision}_BulletDynamics:FILEPATH=/")
	string(REGEX REPLACE "^[^=]*=" "" library "${found}")
	foreach(root ${BULLET})
		cmake_path(IS_PREFIX root "${library}" NORMALIZE is_there)
		if(is_there)
			list(APPEND precisions ${precision})
			set(root_${precision} ${root})
		endif()
	endforeach()
endforeach()
if(NOT precisions)
	message(FATAL_ERROR "no precision of Bullet was found in ${BULLET}")
endif()

function(run_game work)
	run(${CMAKE_COMMAND} -DSOURCE=${SOURCE}/tests/consumer/stock_game -DWORK=${WORK}/${work} -DLAUNCHER=${LAUNCHER} ${ARGN}
		-P ${SOURCE}/tests/consumer/stock_game/RunGame.cmake)
	message(STATUS "${work}:\n${text}")
endfunction()
string(REPLACE ";" "\\;" all "${precisions}")
run_game(find_package -DWAY=find_package -DPREFIX=${WORK}/prefix "-DBULLET_ROOT=${bullet}" "-DPRECISIONS=${all}")
# Both of Bullet's packages have one name.
foreach(precision ${precisions})
	run_game(pkg_config_${precision} -DWAY=pkg_config -DPREFIX=${WORK}/prefix -DBULLET_ROOT=${root_${precision}} -DPRECISIONS=${precision})
endforeach()
run_game(add_subdirectory -DWAY=add_subdirectory -DBULLETHAPTICS_SOURCE=${SOURCE} "-DBULLET_ROOT=${bullet}" "-DPRECISIONS=${all}")
