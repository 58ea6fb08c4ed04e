# SPDX-License-Identifier: Zlib
# An overlay port of this checkout: vcpkg install bullethaptics --overlay-ports=packaging/vcpkg
# Bullet in single precision, as vcpkg's own port builds it by default.
set(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../..")
vcpkg_cmake_configure(
	SOURCE_PATH "${SOURCE_PATH}"
	OPTIONS
		-DBULLETHAPTICS_TOOLS=OFF
		-DBULLETHAPTICS_DEMOS=OFF
		-DBULLETHAPTICS_TESTS=OFF
		-DBULLETHAPTICS_PYTHON=OFF
		-DBULLETHAPTICS_PRELOAD=OFF
		-DBULLETHAPTICS_PNG=OFF
		-DBULLETHAPTICS_WERROR=OFF
		-DBULLETHAPTICS_DRIVER_HAPLY=OFF
		-DBULLETHAPTICS_DRIVER_OPENXR=OFF
		-DBULLETHAPTICS_DRIVER_RUMBLE=OFF
		-DBULLETHAPTICS_DRIVER_SPNAV=OFF
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/BulletHaptics)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
