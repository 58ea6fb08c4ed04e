# SPDX-License-Identifier: Zlib
# Builds the libraries without any optional part: no assimp, OpenMP, drivers of devices, pictures, library to preload, demos, Python, or
# Bullet in double precision. A program that makes its mesh itself uses them from an installation.
# Without OpenMP every file is compiled anew, for minutes; with ccache the second time takes seconds.
# Arguments: SOURCE (the project), WORK, GENERATOR, LAUNCHER.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/RunCommand.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
	-DBULLETHAPTICS_ASSIMP=OFF -DBULLETHAPTICS_OPENMP=OFF -DBULLETHAPTICS_PNG=OFF
	-DBULLETHAPTICS_DRIVER_HAPLY=OFF -DBULLETHAPTICS_DRIVER_OPENXR=OFF
	-DBULLETHAPTICS_DRIVER_RUMBLE=OFF -DBULLETHAPTICS_DRIVER_SPNAV=OFF
	-DBULLETHAPTICS_PRELOAD=OFF -DBULLETHAPTICS_DEMOS=OFF -DBULLETHAPTICS_TESTS=OFF -DBULLETHAPTICS_PYTHON=OFF
	-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
	-DCMAKE_DISABLE_FIND_PACKAGE_assimp=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenMP=ON -DBulletPhysics_Double_LinearMath=)
run(${CMAKE_COMMAND} --build ${WORK}/build --parallel 2)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/prefix)

execute_process(COMMAND ${WORK}/prefix/bin/ist build mesh.obj -o mesh.ist RESULT_VARIABLE code ERROR_VARIABLE words)
if(NOT code EQUAL 1 OR NOT words MATCHES "has no assimp")
	message(FATAL_ERROR "ist build without assimp: ${code}, ${words}")
endif()
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/consumer/bare -B ${WORK}/consumer -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
	-DCMAKE_BUILD_TYPE=Release -DCMAKE_DISABLE_FIND_PACKAGE_assimp=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenMP=ON)
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/bare)
