# Install and export: find_package(BulletHaptics) gives BulletHaptics::Core, ::ISTCollision, ::ISTCollision-float64, ::Devices,
# ::HapticForce, ::TestSupport and ::DeviceBridge with their -float64.
include(CMakePackageConfigHelpers)

install(TARGETS istcore BulletISTCollision BulletISTCollision-float64 devices EXPORT BulletHapticsTargets
	ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY BulletISTCollision/Core/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletISTCollision/Core
	FILES_MATCHING PATTERN "*.h" PATTERN Kernels EXCLUDE)
# By name: the module has headers of its own beside the ones for its users.
install(FILES
	BulletISTCollision/btBulletISTCollisionCommon.h
	BulletISTCollision/btISTCollisionAlgorithm.h
	BulletISTCollision/btISTContactStore.h
	BulletISTCollision/btISTRegistry.h
	BulletISTCollision/btISTShapeMesh.h
	BulletISTCollision/btISTTreeSource.h
	BulletISTCollision/btISTWatch.h
	BulletISTCollision/btPrecisionGuard.h
	DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletISTCollision)
install(TARGETS BulletHapticForce BulletHapticForce-float64 DeviceBridge DeviceBridge-float64 EXPORT BulletHapticsTargets
	ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY BulletHapticForce/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/BulletHapticForce FILES_MATCHING PATTERN "*.h"
	PATTERN btSolverBodyMotion.h EXCLUDE)
install(TARGETS BulletHapticsTestSupport BulletHapticsTestSupport-float64 EXPORT BulletHapticsTargets
	ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY TestSupport/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/TestSupport FILES_MATCHING PATTERN "*.h")
install(DIRECTORY DeviceBridge/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/DeviceBridge FILES_MATCHING PATTERN "*.h"
	PATTERN Plugins EXCLUDE PATTERN OpenXrSession.h EXCLUDE)
install(FILES cmake/FindBulletPhysics.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics)
install(EXPORT BulletHapticsTargets NAMESPACE BulletHaptics::
	DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics)
install(FILES cmake/BulletHapticsAssets.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics)
if(TARGET ist)
	install(TARGETS ist EXPORT BulletHapticsTargets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

configure_package_config_file(cmake/BulletHapticsConfig.cmake.in BulletHapticsConfig.cmake
	INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics)
write_basic_package_version_file(BulletHapticsConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/BulletHapticsConfig.cmake
	${CMAKE_CURRENT_BINARY_DIR}/BulletHapticsConfigVersion.cmake
	DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/BulletHaptics)
