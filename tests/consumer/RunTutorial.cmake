# SPDX-License-Identifier: Zlib
# Installs into a folder and does there what the tutorial and the page about a first hand say.
# With GMOCK it does also what the page about tests says.
# Arguments: BUILD, SOURCE (the project), WORK, GMOCK.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/RunCommand.cmake)

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
set(pages ${SOURCE}/docs/first-hand.md)
if(GMOCK)
	list(APPEND pages ${SOURCE}/docs/testing.md)
endif()
run(python3 ${SOURCE}/tests/docs/run_tutorial.py ${SOURCE}/docs/tutorial.md ${WORK}/prefix ${WORK}/folders ${pages})
message(STATUS "${text}")
