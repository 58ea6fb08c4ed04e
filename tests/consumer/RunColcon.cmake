# SPDX-License-Identifier: Zlib
# Builds and installs the project as a package of ROS by colcon, which reads package.xml, and uses it from there.
# Arguments: SOURCE (the project), WORK, LAUNCHER.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/RunCommand.cmake)

find_program(colcon colcon)
if(NOT colcon)
	message("skipped: no colcon (apt-get install colcon python3-colcon-ros python3-colcon-cmake)")
	return()
endif()
file(REMOVE_RECURSE ${WORK})
run(${colcon} --log-base ${WORK}/log build --base-paths ${SOURCE} --build-base ${WORK}/build --install-base ${WORK}/install
	--cmake-args -GNinja -DCMAKE_BUILD_TYPE=Release -DBULLETHAPTICS_TESTS=OFF -DBULLETHAPTICS_DEMOS=OFF -DBULLETHAPTICS_PYTHON=OFF
	-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
if(NOT EXISTS ${WORK}/install/bullethaptics/share/bullethaptics/package.xml)
	message(FATAL_ERROR "colcon took the project for something else than the package of package.xml: ${text}")
endif()
run(sh -c ". ${WORK}/install/setup.sh && cmake -S ${SOURCE}/tests/consumer/find_package -B ${WORK}/consumer -DCMAKE_BUILD_TYPE=Release")
run(${CMAKE_COMMAND} --build ${WORK}/consumer --parallel 2)
run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK}/consumer --output-on-failure --no-tests=error)
message(STATUS "${text}")
