# SPDX-License-Identifier: Zlib
bullethaptics_driver(OPENXR PACKAGE libopenxr-dev HEADERS openxr/openxr.h LIBRARIES openxr_loader
	SOURCES Drivers/OpenXr/OpenXrLink.cpp Drivers/OpenXr/OpenXrScheme.cpp Drivers/OpenXr/OpenXrSession.cpp)
