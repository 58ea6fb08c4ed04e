# SPDX-License-Identifier: Zlib
# Cross build for 64-bit ARM with Debian's compiler. BULLETHAPTICS_SYSROOT: a folder with the libraries of that architecture, as
# tests/compilers/arm64.sh unpacks one. What is built runs under QEMU's user mode, so that ctest works as usual.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES BULLETHAPTICS_SYSROOT)
set(CMAKE_SYSROOT ${BULLETHAPTICS_SYSROOT})
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64;-L;${BULLETHAPTICS_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
	set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
