# SPDX-License-Identifier: Zlib
# For Windows a zip (BulletHapticsZip.cmake), else
# Debian packages: cmake --preset package && cmake --build --preset package && cpack --config build/package/CPackConfig.cmake
# The packages are libbullethaptics0.2 (shared libraries, both precisions beside each other), libbullethaptics-dev, bullethaptics-tools,
# bullethaptics-demos and python3-bullethaptics.
if(WIN32)
	include(cmake/BulletHapticsZip.cmake)
	return()
endif()
if(NOT BUILD_SHARED_LIBS OR NOT UNIX OR NOT BULLETHAPTICS_BULLET)
	return()
endif()
find_program(BULLETHAPTICS_GZIP gzip)
if(NOT BULLETHAPTICS_GZIP)
	message(STATUS "no Debian packages: gzip is missing")
	return()
endif()
# Not Debian's own packaging.
set(revision 0local1)
set(abi ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(maintainer "BulletHaptics maintainers <maintainers@bullethaptics.invalid>")

# What Debian wants to find in each package: copyright, changelog, manual pages.
set(papers ${CMAKE_CURRENT_BINARY_DIR}/packaging)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(CONFIGURE OUTPUT ${papers}/changelog @ONLY CONTENT
"bullethaptics (@PROJECT_VERSION@-@revision@) unstable; urgency=medium

  * See CHANGELOG.md of the sources.

 -- @maintainer@  @date@
")
file(READ LICENSE license)
string(REGEX REPLACE "\n(\n|$)" "\n .\n" license "\n${license}")
string(REGEX REPLACE "\n([^ \n])" "\n \\1" license "${license}")
string(REGEX REPLACE "( \\.\n)+$" "" license "${license}")
file(WRITE ${papers}/copyright
	"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: BulletHaptics\n\n"
	"Files: *\nCopyright: the BulletHaptics authors\nLicense: Zlib\n\nLicense: Zlib${license}")
function(compressed input output)
	execute_process(COMMAND ${BULLETHAPTICS_GZIP} -9nc ${input} OUTPUT_FILE ${output} COMMAND_ERROR_IS_FATAL ANY)
endfunction()
compressed(${papers}/changelog ${papers}/changelog.Debian.gz)

function(bullethaptics_package component name description)
	cmake_parse_arguments(arg "" "DEPENDS;RECOMMENDS;SUGGESTS;SECTION" "PAGES;EXPLANATION" ${ARGN})
	string(TOUPPER ${component} key)
	set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${name} PARENT_SCOPE)
	set(CPACK_DEBIAN_${key}_PACKAGE_SECTION ${arg_SECTION} PARENT_SCOPE)
	foreach(relation DEPENDS RECOMMENDS SUGGESTS)
		set(CPACK_DEBIAN_${key}_PACKAGE_${relation} "${arg_${relation}}" PARENT_SCOPE)
	endforeach()
	string(REPLACE ";" "\n" explanation "${arg_EXPLANATION}")
	set(CPACK_DEBIAN_${key}_DESCRIPTION "${description}\n${explanation}" PARENT_SCOPE)
	set(CPACK_COMPONENT_${key}_DESCRIPTION "${description}\n${explanation}" PARENT_SCOPE)
	install(FILES ${papers}/copyright ${papers}/changelog.Debian.gz DESTINATION share/doc/${name} COMPONENT ${component})
	foreach(page ${arg_PAGES})
		compressed(${PROJECT_SOURCE_DIR}/packaging/man/${page} ${papers}/${page}.gz)
		install(FILES ${papers}/${page}.gz DESTINATION share/man/man1 COMPONENT ${component})
	endforeach()
	if(EXISTS ${PROJECT_SOURCE_DIR}/packaging/${component}.lintian-overrides)
		configure_file(${PROJECT_SOURCE_DIR}/packaging/${component}.lintian-overrides ${papers}/${name} @ONLY)
		install(FILES ${papers}/${name} DESTINATION share/lintian/overrides COMPONENT ${component})
	endif()
endfunction()
set(same "(= ${PROJECT_VERSION}-${revision})")
bullethaptics_package(runtime libbullethaptics${abi} "volumetric contact for Bullet Physics, shared libraries" SECTION libs EXPLANATION
	"Contact that can be felt: overlap volume, force and torque between any two"
	"closed meshes, from inner sphere trees. For Bullet in single and in double" "precision.")
bullethaptics_package(dev libbullethaptics-dev "volumetric contact for Bullet Physics, development files" SECTION libdevel
	DEPENDS "libbullethaptics${abi} ${same}, libbullet-dev" SUGGESTS "libgmock-dev, libbullet-extras-dev" EXPLANATION
	"Headers, CMake package and pkg-config files of BulletHaptics, for Bullet in"
	"single and in double precision, and matchers for the physics tests of games.")
bullethaptics_package(tools bullethaptics-tools "volumetric contact for Bullet Physics, command-line tools" SECTION science
	DEPENDS "libbullethaptics${abi} ${same}" PAGES ist.1 devicebridge.1 EXPLANATION
	"ist packs meshes with spheres, checks and queries the result; devicebridge" "lists, tries, records and measures haptic devices.")
bullethaptics_package(demos bullethaptics-demos "volumetric contact for Bullet Physics, demos" SECTION science
	DEPENDS "libbullethaptics${abi} ${same}" RECOMMENDS glmark2-data PAGES haptic_demos.1 EXPLANATION
	"A browser of demos in a window. They and scene files of one's own also run"
	"without a display, and write reports with charts: bodies that fall, grasp and"
	"screw, and a simulated hand that presses a rod on a mesh, among others.")
if(TARGET bullethaptics_python)
	math(EXPR next "${BULLETHAPTICS_PYTHON_MINOR} + 1")
	bullethaptics_package(python python3-bullethaptics "volumetric contact between closed meshes, Python module" SECTION python
		DEPENDS "libbullethaptics${abi} ${same}, python3 (>= 3.${BULLETHAPTICS_PYTHON_MINOR}~), python3 (<< 3.${next}), python3-numpy" EXPLANATION
		"Packs meshes with spheres, and asks for overlap volume, force and torque of" "many poses in one call, on NumPy arrays.")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME bullethaptics)
set(CPACK_PACKAGE_VENDOR "BulletHaptics")
set(CPACK_PACKAGE_CONTACT "${maintainer}")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL runtime dev)
foreach(component tools demos)
	string(TOUPPER ${component} key)
	if(BULLETHAPTICS_${key})
		list(APPEND CPACK_COMPONENTS_ALL ${component})
	endif()
endforeach()
if(TARGET bullethaptics_python)
	list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${revision})
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${maintainer}")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_CURRENT_BINARY_DIR}/BulletISTCollision ${CMAKE_CURRENT_BINARY_DIR}/BulletHapticForce
	${CMAKE_CURRENT_BINARY_DIR}/TestSupport ${CMAKE_CURRENT_BINARY_DIR}/DeviceBridge)
# By hand: CPack would also list the plug-ins, which nobody links with.
set(shlibs "")
foreach(library istcore devices ${bullet_libraries})
	get_target_property(name ${library} OUTPUT_NAME)
	if(NOT name)
		set(name ${library})
	endif()
	string(APPEND shlibs "lib${name} ${abi} libbullethaptics${abi} ${same}\n")
endforeach()
file(WRITE ${papers}/shlibs "${shlibs}")
file(WRITE ${papers}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${papers}/triggers ${papers}/shlibs)
include(CPack)
