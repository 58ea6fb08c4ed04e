# SPDX-License-Identifier: Zlib
# Installs a build, and builds a program from there, as a user would.
# Arguments: BUILD, which is installed; SOURCE; WORK; SANITIZE; OPENMP, whether static libraries need it.
function(run)
	execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
	if(NOT code EQUAL 0)
		message(FATAL_ERROR "${ARGN}: ${code}\n${text}")
	endif()
	message(STATUS "${text}")
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
set(flags "")
if(SANITIZE)
	set(flags -fsanitize=${SANITIZE})
endif()
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -DCMAKE_PREFIX_PATH=${WORK}/prefix
	-DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS=${flags} -DSANITIZE=${SANITIZE})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK}/build --output-on-failure --no-tests=error)

# A program that asks for what needs no Bullet finds it where there is none; one that asks for more does not.
set(without_bullet ${CMAKE_COMMAND} -S ${SOURCE}/../without_bullet -B ${WORK}/without_bullet
	-DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_DISABLE_FIND_PACKAGE_BulletPhysics=ON)
run(${without_bullet})
execute_process(COMMAND ${without_bullet} "-DCOMPONENTS=Core\;HapticForce" RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE text)
if(code EQUAL 0 OR NOT text MATCHES "BulletPhysics")
	message(FATAL_ERROR "HapticForce without Bullet: ${code}\n${text}")
endif()
# The program that reads mesh files is that of the installation, and the sentence without it says what to do.
file(GLOB importer ${WORK}/prefix/lib/bullethaptics-*/bullethaptics-import ${WORK}/prefix/lib/*/bullethaptics-*/bullethaptics-import)
file(RENAME ${importer} ${importer}-elsewhere)
execute_process(COMMAND ${WORK}/build/core RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text WORKING_DIRECTORY ${WORK}/build)
if(code EQUAL 0 OR NOT text MATCHES "bullethaptics-import, which is not there; install it with the library")
	message(FATAL_ERROR "without bullethaptics-import: ${code}\n${text}")
endif()
run(${CMAKE_COMMAND} -E env BULLETHAPTICS_IMPORT=${importer}-elsewhere ${WORK}/build/core)

# Where the compiler has no OpenMP it is said what to do.
if(OPENMP)
	execute_process(
		COMMAND ${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/no_openmp
			-DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_DISABLE_FIND_PACKAGE_OpenMP=ON
		RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
	string(REGEX REPLACE "[ \n]+" " " text "${text}")
	if(code EQUAL 0 OR NOT text MATCHES "apt-get install libomp-dev")
		message(FATAL_ERROR "static libraries and no OpenMP: ${code}\n${text}")
	endif()
endif()
