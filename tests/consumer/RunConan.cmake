# SPDX-License-Identifier: Zlib
# Makes the Conan package with Debian's libraries and runs a program against it. SOURCE (the project), WORK, CONAN (the program).
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/RunCommand.cmake)

if(NOT CONAN)
	message("skipped: no conan")
	return()
endif()
set(ENV{CONAN_HOME} ${WORK})
run(${CONAN} profile detect --force)
run(${CONAN} create ${SOURCE}/packaging/conan -pr:a ${SOURCE}/packaging/conan/debian.profile --no-remote)
message(STATUS "${text}")
