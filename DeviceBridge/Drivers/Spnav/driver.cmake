# SPDX-License-Identifier: Zlib
# Debian's libspnav names neither the mathematics library nor the headers of Xlib that it needs.
bullethaptics_driver(SPNAV PACKAGE "libspnav-dev libx11-dev" HEADERS spnav.h X11/Xlib.h LIBRARIES spnav m
	SOURCES Drivers/Spnav/SpnavLink.cpp Drivers/Spnav/SpnavScheme.cpp)
