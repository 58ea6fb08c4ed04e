# SPDX-License-Identifier: Zlib
# Assets as part of a build:
#
#   bullethaptics_add_assets(<target> MESHES <file>...
#     [SPHERES n] [FILL f] [MIN_RADIUS m] [ERROR e] [UNIT m|cm|mm|um|in|ft|metres] [UP axis] [REPAIR auto|off|wrap|"ground DEPTH [AXIS]"]
#     [ACCEPT_DOUBT] [SEED n] [THREADS n] [OUTPUT_DIRECTORY <folder>] [DEPENDS <file>...])
#
# Adds <target>, part of ALL, which packs each mesh into <folder>/<name>.ist (default folder: the current binary directory). The
# assets build side by side, one thread each unless THREADS says otherwise, and again only when the mesh, a file in DEPENDS, a
# setting or the `ist` command changed. A mesh that repair changed is named in the build's output, with what was done. The target
# property BULLETHAPTICS_ASSETS lists the files. AXIS is that of the mesh which UP turned, and the one to which UP turns by default.
# Settings mean what they mean to `ist build`:
# with ACCEPT_DOUBT it also builds meshes of which repair may have guessed more than half of the volume (--accept-doubt).
function(bullethaptics_add_assets target)
	set(settings SPHERES FILL MIN_RADIUS ERROR UNIT UP REPAIR SEED)
	cmake_parse_arguments(PARSE_ARGV 1 arg "ACCEPT_DOUBT" "${settings};THREADS;OUTPUT_DIRECTORY" "MESHES;DEPENDS")
	if(arg_UNPARSED_ARGUMENTS OR arg_KEYWORDS_MISSING_VALUES OR NOT arg_MESHES)
		message(FATAL_ERROR "bullethaptics_add_assets(${target}): cannot make sense of \"${ARGN}\"")
	endif()
	if(NOT TARGET BulletHaptics::ist)
		message(FATAL_ERROR "bullethaptics_add_assets(${target}): BulletHaptics was built without its tools (BULLETHAPTICS_TOOLS)")
	endif()
	if(NOT arg_OUTPUT_DIRECTORY)
		set(arg_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
	endif()
	cmake_path(ABSOLUTE_PATH arg_OUTPUT_DIRECTORY BASE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} NORMALIZE)
	if(NOT arg_THREADS)
		set(arg_THREADS 1)
	endif()

	set(options "")
	foreach(setting ${settings})
		if(DEFINED arg_${setting})
			string(TOLOWER "--${setting}" option)
			string(REPLACE "_" "-" option "${option}")
			list(APPEND options ${option} "${arg_${setting}}")
		endif()
	endforeach()

	if(arg_ACCEPT_DOUBT)
		list(APPEND options --accept-doubt)
	endif()

	set(assets "")
	foreach(mesh ${arg_MESHES})
		cmake_path(ABSOLUTE_PATH mesh NORMALIZE)
		cmake_path(GET mesh STEM LAST_ONLY name)
		set(asset ${arg_OUTPUT_DIRECTORY}/${name}.ist)
		if(asset IN_LIST assets)
			message(FATAL_ERROR "bullethaptics_add_assets(${target}): two meshes are named ${name}; give them folders of their own")
		endif()
		# Make does not compare command lines: the settings are a file that changes only when they do.
		set(stamp ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/${name}.settings)
		file(CONFIGURE OUTPUT ${stamp} CONTENT "${options}\n" @ONLY)
		add_custom_command(OUTPUT ${asset}
			COMMAND ${CMAKE_COMMAND} -E make_directory ${arg_OUTPUT_DIRECTORY}
			COMMAND BulletHaptics::ist build ${mesh} -o ${asset} ${options} --threads ${arg_THREADS} --quiet
			DEPENDS ${mesh} ${stamp} ${arg_DEPENDS} $<TARGET_FILE:BulletHaptics::ist>
			COMMENT "Packing ${name}.ist"
			VERBATIM)
		list(APPEND assets ${asset})
	endforeach()
	add_custom_target(${target} ALL DEPENDS ${assets})
	set_target_properties(${target} PROPERTIES BULLETHAPTICS_ASSETS "${assets}")
endfunction()
