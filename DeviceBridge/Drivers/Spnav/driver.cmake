# SPDX-License-Identifier: Zlib
# Debian's libspnav declares neither the mathematics library nor the Xlib headers that it needs.
bullethaptics_driver(SPNAV PACKAGE "libspnav-dev libx11-dev" HEADERS spnav.h X11/Xlib.h LIBRARIES spnav m
	SOURCES Drivers/Spnav/SpnavLink.cpp Drivers/Spnav/SpnavScheme.cpp)
