# SPDX-License-Identifier: Zlib
bullethaptics_driver(HAPLY PACKAGE libboost-dev HEADERS boost/beast/websocket.hpp
	SOURCES Drivers/Haply/HaplyLink.cpp Drivers/Haply/HaplyMessages.cpp Drivers/Haply/HaplyScheme.cpp)
