# SPDX-License-Identifier: Zlib
# pkg-config files: bullethaptics-core and -devices, and in both precisions of Bullet bullethaptics-collision, -force, -test-support and
# -device-bridge. They find their folder themselves, so that an installation may be moved.
function(bullethaptics_pkg_config name description requires libraries)
	set(definitions "${ARGN}")
	file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
	string(REGEX REPLACE "/$" "" up "${up}")
	file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/pkgconfig/bullethaptics-${name}.pc @ONLY CONTENT
[[prefix=${pcfiledir}/@up@
libdir=${prefix}/@CMAKE_INSTALL_LIBDIR@
includedir=${prefix}/@CMAKE_INSTALL_INCLUDEDIR@

Name: bullethaptics-@name@
Description: @description@
Version: @PROJECT_VERSION@
Requires: @requires@
Libs: -L${libdir} @libraries@
Cflags: -I${includedir}@definitions@
]])
	install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pkgconfig/bullethaptics-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
endfunction()

# The libraries that a static target was given by path or by name, as the linker finds them.
function(bullethaptics_linker_flags target output)
	set(flags "")
	get_target_property(links ${target} LINK_LIBRARIES)
	foreach(link ${links})
		cmake_path(GET link PARENT_PATH folder)
		cmake_path(GET link STEM name)
		if(IS_ABSOLUTE "${link}" AND name MATCHES "^lib")
			if(NOT folder IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES)
				string(APPEND flags " -L${folder}")
			endif()
			string(REGEX REPLACE "^lib" " -l" name "${name}")
			string(APPEND flags "${name}")
		endif()
	endforeach()
	list(TRANSFORM CMAKE_DL_LIBS PREPEND " -l" OUTPUT_VARIABLE dl)
	set(${output} "${flags}${dl}" PARENT_SCOPE)
endfunction()

set(core_libraries "-listcore")
set(devices_libraries "-lBulletHapticsDevices")
if(NOT BUILD_SHARED_LIBS)
	list(TRANSFORM CMAKE_DL_LIBS PREPEND " -l" OUTPUT_VARIABLE dl)
	string(APPEND core_libraries " -pthread" ${dl})
	if(BULLETHAPTICS_OPENMP)
		string(APPEND core_libraries " ${OpenMP_CXX_FLAGS}")
	endif()
	bullethaptics_linker_flags(devices flags)
	string(APPEND devices_libraries "${flags}")
endif()
bullethaptics_pkg_config(core "Overlap of closed meshes from inner sphere trees" "" "${core_libraries}")
bullethaptics_pkg_config(devices "Haptic devices and hands" "bullethaptics-core" "${devices_libraries}")
foreach(precision ${BULLETHAPTICS_PRECISIONS})
	set(suffix ${suffix_${precision}})
	# Bullet's own build gives its package the same name in both precisions, and does not say whether it was built for threads.
	# Both answers therefore come from what FindBulletPhysics.cmake found.
	string(REGEX MATCH "-float64" bullet_suffix "${BulletPhysics_${precision}_BulletDynamics}")
	set(threads "")
	if(BulletPhysics_${precision}_THREADSAFE)
		set(threads " -DBT_THREADSAFE=1")
	endif()
	# Bullet first: other packages name the system's folder, in which there may be another Bullet.
	bullethaptics_pkg_config(collision${suffix} "Volumetric collision detection for Bullet" "bullet${bullet_suffix} bullethaptics-core"
		"-lBulletISTCollision${suffix}" "${threads}")
	bullethaptics_pkg_config(force${suffix} "Volumetric contact for Bullet" "bullethaptics-collision${suffix}" "-lBulletHapticForce${suffix}")
	bullethaptics_pkg_config(test-support${suffix} "Physics tests for games with volumetric contact" "bullethaptics-force${suffix}"
		"-lBulletHapticsTestSupport${suffix}")
	bullethaptics_pkg_config(device-bridge${suffix} "Haptic devices and hands in a Bullet world"
		"bullethaptics-force${suffix} bullethaptics-devices" "-lDeviceBridge${suffix}")
endforeach()
