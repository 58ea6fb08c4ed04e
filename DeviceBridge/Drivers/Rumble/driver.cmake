# SPDX-License-Identifier: Zlib
bullethaptics_driver(RUMBLE PACKAGE libsdl2-dev HEADERS SDL2/SDL.h LIBRARIES SDL2
	SOURCES Drivers/Rumble/RumbleLink.cpp Drivers/Rumble/RumbleScheme.cpp)
