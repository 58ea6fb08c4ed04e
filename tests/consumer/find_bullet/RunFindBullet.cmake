# SPDX-License-Identifier: Zlib
# Bullet as its own build installs it, with both precisions under the same names.
# FindBulletPhysics.cmake must tell the precisions apart, and never mix folders.
# Arguments: MODULES, the folder of the module; WORK; INCLUDE, Bullet's headers; SINGLE and DOUBLE, BulletDynamics in each precision, as
# Debian has it.
cmake_minimum_required(VERSION 3.25)

include(${CMAKE_CURRENT_LIST_DIR}/../RunCommand.cmake)

file(REMOVE_RECURSE ${WORK})
foreach(precision SINGLE DOUBLE)
	cmake_path(GET ${precision} EXTENSION LAST_ONLY extension)
	file(MAKE_DIRECTORY ${WORK}/${precision}/lib ${WORK}/${precision}/include)
	file(CREATE_LINK ${INCLUDE} ${WORK}/${precision}/include/bullet SYMBOLIC)
	foreach(library BulletDynamics BulletCollision LinearMath)
		string(REPLACE BulletDynamics ${library} file "${${precision}}")
		file(CREATE_LINK ${file} ${WORK}/${precision}/lib/lib${library}${extension} SYMBOLIC)
	endforeach()
endforeach()

function(finds expected)
	list(JOIN ARGN "\\;" roots)
	string(REPLACE ";" "\\;" expected "${expected}")
	file(REMOVE_RECURSE ${WORK}/build)
	run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_FUNCTION_LIST_DIR} -B ${WORK}/build -DCMAKE_MODULE_PATH=${MODULES}
		"-DBULLET_ROOT=${roots}" "-DEXPECTED=${expected}" -DCMAKE_CXX_COMPILER_WORKS=ON)
endfunction()
finds("Single" ${WORK}/SINGLE)
finds("Double" ${WORK}/DOUBLE)
finds("Single;Double" ${WORK}/DOUBLE ${WORK}/SINGLE)
finds("" ${WORK})
