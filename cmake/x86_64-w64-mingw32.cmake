# SPDX-License-Identifier: Zlib
# Cross build for 64-bit Windows with Debian's mingw-w64, whose threads are those of POSIX. BULLETHAPTICS_WINDOWS_ROOT: the folder with the
# libraries of that system, as cmake/windows_dependencies.sh makes it. What is built runs under Wine, so that ctest works as usual.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
if(NOT BULLETHAPTICS_WINDOWS_ROOT)
	set(BULLETHAPTICS_WINDOWS_ROOT "$ENV{HOME}/.cache/bullethaptics/windows/root")
endif()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES BULLETHAPTICS_WINDOWS_ROOT)
set(CMAKE_FIND_ROOT_PATH ${BULLETHAPTICS_WINDOWS_ROOT} /usr/x86_64-w64-mingw32)
set(CMAKE_PREFIX_PATH ${BULLETHAPTICS_WINDOWS_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
	set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
# The libraries of the compiler are in the program, so that it runs on a machine without them.
foreach(kind EXE SHARED MODULE)
	set(CMAKE_${kind}_LINKER_FLAGS_INIT -static)
endforeach()
# Otherwise the assembler finds too many sections in tests with many templates.
set(CMAKE_CXX_FLAGS_INIT -Wa,-mbig-obj)
find_program(BULLETHAPTICS_WINE NAMES wine64 PATHS /usr/lib/wine)
mark_as_advanced(BULLETHAPTICS_WINE)
if(BULLETHAPTICS_WINE)
	set(CMAKE_CROSSCOMPILING_EMULATOR ${BULLETHAPTICS_WINE})
endif()
