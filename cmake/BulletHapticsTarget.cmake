# SPDX-License-Identifier: Zlib
# Settings that every target of this project shares.
function(bullethaptics_target target)
	target_compile_features(${target} PRIVATE cxx_std_20)
	set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON DEFINE_SYMBOL "")
	# Shared libraries: until 1.0 every minor version may change the ABI.
	get_target_property(kind ${target} TYPE)
	# Otherwise a DLL would export the functions of the compiler's libraries that are in it, too.
	if(MINGW AND kind MATCHES "SHARED_LIBRARY|MODULE_LIBRARY")
		target_link_options(${target} PRIVATE -Wl,--exclude-libs,ALL)
	endif()
	if(kind STREQUAL "SHARED_LIBRARY")
		set_target_properties(${target} PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
		if((UNIX AND NOT APPLE) OR MINGW)
			set(hidden ${PROJECT_SOURCE_DIR}/cmake/hidden.map)
			target_link_options(${target} PRIVATE -Wl,--version-script=${hidden})
			set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${hidden})
		endif()
	endif()
	# The same sums on every compiler: packings and trees must not depend on which one contracts a*b+c.
	# -Wrestrict is wrong about std::string in GCC 12 (GCC bug 105651). Clang 17 and later report a deprecated function that libstdc++ 12
	# itself calls in std::stable_sort.
	# clang-cl takes options in Visual Studio's spelling, and clang's own behind /clang:.
	set(options -Wall -Wextra -ffp-contract=off -fno-math-errno)
	if(MSVC)
		set(options /W4 /EHsc /bigobj /utf-8 /clang:-ffp-contract=off /clang:-fno-math-errno)
	endif()
	target_compile_options(${target} PRIVATE ${options}
		$<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
		$<$<AND:$<CXX_COMPILER_ID:Clang>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,17>>:-Wno-deprecated-declarations>
		$<$<NOT:$<BOOL:${BULLETHAPTICS_OPENMP}>>:-Wno-unknown-pragmas>
		$<$<BOOL:${BULLETHAPTICS_WERROR}>:-Werror>)
	if(BULLETHAPTICS_SANITIZE)
		# Boost.Asio has fences, which GCC's thread sanitizer does not know; each of our contexts is used by one thread.
		target_compile_options(${target} PRIVATE -fsanitize=${BULLETHAPTICS_SANITIZE} -fno-omit-frame-pointer
			-fno-sanitize-recover=all $<$<CXX_COMPILER_ID:GNU>:-Wno-tsan>)
		# These three checks take 40 % of the time to compile. The address sanitizer finds what the first two look for when it is accessed,
		# and only the kernels have instructions that need alignment.
		if(BULLETHAPTICS_SANITIZE MATCHES "address.*undefined" AND NOT target MATCHES "^istkernel")
			target_compile_options(${target} PRIVATE -fno-sanitize=null,object-size,alignment)
		endif()
		target_link_options(${target} PUBLIC -fsanitize=${BULLETHAPTICS_SANITIZE})
		# As is usual for libFuzzer; clang does not define it for its libraries.
		if(BULLETHAPTICS_SANITIZE MATCHES "fuzzer")
			target_compile_definitions(${target} PRIVATE FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION)
		endif()
	endif()
endfunction()
