# SPDX-License-Identifier: Zlib
# Install and export: find_package(BulletHaptics) gives BulletHaptics::Core, ::ISTCollision, ::ISTCollision-float64, ::Devices,
# ::HapticForce, ::TestSupport and ::DeviceBridge with their -float64. Components: runtime (shared libraries), dev, tools, demos.
include(CMakePackageConfigHelpers)

# Two exports: a program that asks for Core and Devices only needs no Bullet.
function(bullethaptics_export export)
	install(TARGETS ${ARGN} EXPORT ${export}
		ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
		LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev
		RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
	install(EXPORT ${export} NAMESPACE BulletHaptics:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics COMPONENT dev)
endfunction()
set_target_properties(devices PROPERTIES OUTPUT_NAME BulletHapticsDevices)
bullethaptics_export(BulletHapticsTargets istcore devices)
set(bullet_libraries "")
foreach(precision ${BULLETHAPTICS_PRECISIONS})
	foreach(library BulletISTCollision BulletHapticForce BulletHapticsTestSupport DeviceBridge)
		list(APPEND bullet_libraries ${library}${suffix_${precision}})
	endforeach()
endforeach()
if(BULLETHAPTICS_BULLET)
	bullethaptics_export(BulletHapticsBulletTargets ${bullet_libraries})
endif()
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/generated/BulletISTCollision/Core/Base/Version.h
	DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletISTCollision/Core/Base COMPONENT dev)
foreach(header ${BULLETHAPTICS_HEADERS})
	cmake_path(GET header PARENT_PATH folder)
	install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder} COMPONENT dev)
endforeach()
bullethaptics_forward_old_paths()

# In a folder of this version, beside the shared library, which looks for it there.
set(importer_folder ${CMAKE_INSTALL_LIBDIR}/${BULLETHAPTICS_IMPORTER_FOLDER})
if(TARGET bullethaptics-import)
	install(TARGETS bullethaptics-import RUNTIME DESTINATION ${importer_folder} COMPONENT runtime)
endif()

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics)
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
	install(DIRECTORY data/studies DESTINATION ${CMAKE_INSTALL_DATADIR}/BulletHaptics COMPONENT demos)
endif()
if(BULLETHAPTICS_BULLET)
	install(DIRECTORY data/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/BulletHaptics COMPONENT ${scenes_component})
endif()
set(scene_folder ${CMAKE_INSTALL_DATADIR}/BulletHaptics/scenes)

configure_package_config_file(cmake/BulletHapticsConfig.cmake.in BulletHapticsConfig.cmake
	INSTALL_DESTINATION ${package_folder} PATH_VARS scene_folder importer_folder)
write_basic_package_version_file(BulletHapticsConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
	${CMAKE_CURRENT_BINARY_DIR}/BulletHapticsConfig.cmake
	${CMAKE_CURRENT_BINARY_DIR}/BulletHapticsConfigVersion.cmake
	cmake/BulletHapticsAssets.cmake
	BulletISTCollision/Core/Import/ImporterOfBuild.cpp.in
	DESTINATION ${package_folder} COMPONENT dev)
if(BULLETHAPTICS_BULLET)
	install(FILES cmake/FindBulletPhysics.cmake DESTINATION ${package_folder} COMPONENT dev)
endif()
# Where ROS looks for it.
install(FILES package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/bullethaptics COMPONENT dev)
