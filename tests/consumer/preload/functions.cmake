# SPDX-License-Identifier: Zlib
# For the tests of the library to preload.

# run(LIBRARY EXPECTED COMMAND...): `text` is what it prints on stdout, `errors` on stderr.
function(run library)
	execute_process(COMMAND ${CMAKE_COMMAND} -E env LD_PRELOAD=${library} ${ARGN}
		RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE errors)
	if(NOT code EQUAL 0)
		message(FATAL_ERROR "${ARGN} with ${library}: ${code}\n${errors}")
	endif()
	set(text "${text}" PARENT_SCOPE)
	set(errors "${errors}" PARENT_SCOPE)
endfunction()
function(expect_said sentence)
	if(NOT errors MATCHES "${sentence}")
		message(FATAL_ERROR "not said: ${sentence}\nbut: ${errors}")
	endif()
endfunction()
function(expect_silent what)
	if(errors MATCHES "bullethaptics")
		message(FATAL_ERROR "${what}: ${errors}")
	endif()
endfunction()

# Waits until the packer has made a tree in this folder and has nothing left to do. `trees` is what the folder has.
function(expect_packed folder)
	foreach(i RANGE 3000)
		file(GLOB trees ${folder}/*.ist)
		file(GLOB orders ${folder}/*.wanted ${folder}/*.taken)
		if(trees AND NOT orders)
			set(trees ${trees} PARENT_SCOPE)
			return()
		endif()
		execute_process(COMMAND ${CMAKE_COMMAND} -E sleep 0.1)
	endforeach()
	message(FATAL_ERROR "nobody packs what the program has left behind: ${orders}")
endfunction()
