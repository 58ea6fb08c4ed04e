# SPDX-License-Identifier: Zlib
# A zip for Windows: cmake --preset windows-dll && cmake --build --preset windows-dll && (cd build/windows-dll && cpack)
# It holds libraries, commands, plug-ins, headers and the CMake package, and what they need: Bullet with its headers, and in bin the
# libraries of the compiler. BULLETHAPTICS_NOTICES: a folder with the licences of these, which the zip takes along.
set(BULLETHAPTICS_NOTICES "" CACHE PATH "Licences of other people's libraries in the zip for Windows")
set(notices ${CMAKE_INSTALL_DATADIR}/doc/BulletHaptics)
install(FILES LICENSE CHANGELOG.md DESTINATION ${notices} COMPONENT runtime)
if(BULLETHAPTICS_NOTICES)
	install(DIRECTORY ${BULLETHAPTICS_NOTICES}/ DESTINATION ${notices} COMPONENT runtime)
endif()

# A Bullet of another build would be another library: shared ones of ours and a game have one Bullet.
foreach(precision ${BULLETHAPTICS_PRECISIONS})
	foreach(library LinearMath BulletCollision BulletDynamics)
		set(file ${BulletPhysics_${precision}_${library}})
		install(FILES ${file} DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
		if(file MATCHES "/([^/]+)\\.dll\\.a$")
			cmake_path(GET file PARENT_PATH folder)
			install(FILES ${folder}/../bin/${CMAKE_MATCH_1}.dll DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
		endif()
	endforeach()
	install(DIRECTORY ${BulletPhysics_${precision}_INCLUDE_DIR}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/bullet COMPONENT dev
		FILES_MATCHING PATTERN "*.h")
endforeach()

# Static libraries need those of the compiler, too, but the program that is linked has them in itself.
if(MINGW AND BUILD_SHARED_LIBS)
	set(names libstdc++-6 libgcc_s_seh-1 libwinpthread-1)
	if(BULLETHAPTICS_OPENMP)
		list(APPEND names libgomp-1)
	endif()
	cmake_path(GET CMAKE_CXX_COMPILER PARENT_PATH beside)
	foreach(name ${names})
		execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=${name}.dll
			OUTPUT_VARIABLE file OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
		if(NOT IS_ABSOLUTE "${file}")
			set(file ${beside}/${name}.dll)
		endif()
		install(FILES ${file} DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
	endforeach()
endif()

set(compiler msvc)
if(MINGW)
	set(compiler mingw-w64)
endif()
set(CPACK_GENERATOR ZIP)
set(CPACK_PACKAGE_NAME BulletHaptics)
set(CPACK_PACKAGE_VENDOR "BulletHaptics")
set(CPACK_PACKAGE_FILE_NAME BulletHaptics-${PROJECT_VERSION}-windows-x86_64-${compiler})
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
set(CPACK_STRIP_FILES ON)
include(CPack)
