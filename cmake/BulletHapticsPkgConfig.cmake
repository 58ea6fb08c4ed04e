# pkg-config files: bullethaptics-core, and bullethaptics-collision, -force and -test-support in both precisions of Bullet. They find their
# folder themselves, so that an installation may be moved.
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
URL: @PROJECT_HOMEPAGE_URL@
Version: @PROJECT_VERSION@
Requires: @requires@
Libs: -L${libdir} @libraries@
Cflags: -I${includedir}@definitions@
]])
	install(FILES ${CMAKE_CURRENT_BINARY_DIR}/pkgconfig/bullethaptics-${name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
endfunction()

set(core_libraries "-listcore")
set(core_requires "")
if(NOT BUILD_SHARED_LIBS)
	if(BULLETHAPTICS_ASSIMP)
		set(core_requires "assimp")
	endif()
	string(APPEND core_libraries " -pthread")
	if(BULLETHAPTICS_OPENMP)
		string(APPEND core_libraries " ${OpenMP_CXX_FLAGS}")
	endif()
endif()
bullethaptics_pkg_config(core "Overlap of closed meshes from inner sphere trees" "${core_requires}" "${core_libraries}")
foreach(precision ${BULLETHAPTICS_PRECISIONS})
	set(suffix ${suffix_${precision}})
	# As FindBulletPhysics.cmake does: Bullet's own build names its package alike in both precisions, and does not say that it was made for threads.
	string(REGEX MATCH "-float64" bullet_suffix "${BulletPhysics_${precision}_BulletDynamics}")
	set(threads "")
	if(BulletPhysics_${precision}_THREADSAFE)
		set(threads " -DBT_THREADSAFE=1")
	endif()
	bullethaptics_pkg_config(collision${suffix} "Volumetric collision detection for Bullet" "bullethaptics-core bullet${bullet_suffix}"
		"-lBulletISTCollision${suffix}" "${threads}")
	bullethaptics_pkg_config(force${suffix} "Volumetric contact for Bullet" "bullethaptics-collision${suffix}" "-lBulletHapticForce${suffix}")
	bullethaptics_pkg_config(test-support${suffix} "Physics tests for games with volumetric contact" "bullethaptics-force${suffix}"
		"-lBulletHapticsTestSupport${suffix}")
endforeach()
