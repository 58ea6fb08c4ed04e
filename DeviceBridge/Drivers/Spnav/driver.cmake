# Debian's libspnav does not name the mathematics library that it needs.
bullethaptics_driver(SPNAV PACKAGE libspnav-dev HEADERS spnav.h X11/Xlib.h LIBRARIES spnav m
	SOURCES Drivers/Spnav/SpnavLink.cpp Drivers/Spnav/SpnavScheme.cpp)
