# SPDX-License-Identifier: Zlib
# Install and export: find_package(BulletHaptics) gives BulletHaptics::Core, ::ISTCollision, ::ISTCollision-float64, ::Devices,
# ::HapticForce, ::TestSupport and ::DeviceBridge with their -float64. Components: runtime (shared libraries), dev, tools, demos.
include(CMakePackageConfigHelpers)

set(libraries istcore devices)
foreach(precision ${BULLETHAPTICS_PRECISIONS})
	foreach(library BulletISTCollision BulletHapticForce BulletHapticsTestSupport DeviceBridge)
		list(APPEND libraries ${library}${suffix_${precision}})
	endforeach()
endforeach()
set_target_properties(devices PROPERTIES OUTPUT_NAME BulletHapticsDevices)
install(TARGETS ${libraries} EXPORT BulletHapticsTargets
	ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
	LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev)
install(DIRECTORY BulletISTCollision/Core/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletISTCollision/Core COMPONENT dev
	FILES_MATCHING PATTERN "*.h" PATTERN Kernels EXCLUDE)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/generated/BulletISTCollision/Core/Version.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletISTCollision/Core
	COMPONENT dev)
# By name: the module has headers of its own beside the ones for its users.
install(FILES
	BulletISTCollision/btBulletISTCollisionCommon.h
	BulletISTCollision/btISTCollisionAlgorithm.h
	BulletISTCollision/btISTContactStore.h
	BulletISTCollision/btISTEconomy.h
	BulletISTCollision/btISTRegistry.h
	BulletISTCollision/btISTShapeMesh.h
	BulletISTCollision/btISTTreeSource.h
	BulletISTCollision/btISTWatch.h
	BulletISTCollision/btPrecisionGuard.h
	DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletISTCollision COMPONENT dev)
install(DIRECTORY BulletHapticForce/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletHapticForce COMPONENT dev FILES_MATCHING PATTERN "*.h"
	PATTERN btSolverBodyMotion.h EXCLUDE PATTERN Preload EXCLUDE)
install(DIRECTORY TestSupport/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/TestSupport COMPONENT dev FILES_MATCHING PATTERN "*.h")
install(DIRECTORY DeviceBridge/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/DeviceBridge COMPONENT dev FILES_MATCHING PATTERN "*.h"
	PATTERN Plugins EXCLUDE PATTERN OpenXrSession.h EXCLUDE)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics)
install(EXPORT BulletHapticsTargets NAMESPACE BulletHaptics:: DESTINATION ${package_folder} COMPONENT dev)
if(TARGET ist)
	# An export of its own: the libraries can be used where the tools are not installed.
	install(TARGETS ist EXPORT BulletHapticsTools RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT tools)
	install(EXPORT BulletHapticsTools NAMESPACE BulletHaptics:: DESTINATION ${package_folder} COMPONENT tools)
endif()
# Scene files are for the demos and for tests: beside the demos where these are built.
set(scenes_component dev)
if(TARGET haptic_demos)
	install(TARGETS haptic_demos RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT demos)
	set(scenes_component demos)
endif()
install(DIRECTORY data/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/BulletHaptics COMPONENT ${scenes_component})
set(scene_folder ${CMAKE_INSTALL_DATADIR}/BulletHaptics/scenes)

configure_package_config_file(cmake/BulletHapticsConfig.cmake.in BulletHapticsConfig.cmake INSTALL_DESTINATION ${package_folder} PATH_VARS scene_folder)
write_basic_package_version_file(BulletHapticsConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
	${CMAKE_CURRENT_BINARY_DIR}/BulletHapticsConfig.cmake
	${CMAKE_CURRENT_BINARY_DIR}/BulletHapticsConfigVersion.cmake
	cmake/BulletHapticsAssets.cmake
	cmake/FindBulletPhysics.cmake
	DESTINATION ${package_folder} COMPONENT dev)
# Where ROS looks for it.
install(FILES package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/bullethaptics COMPONENT dev)
