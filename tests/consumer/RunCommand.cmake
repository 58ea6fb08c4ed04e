# SPDX-License-Identifier: Zlib
# run(COMMAND...): `text` is all that the command prints; where it fails, so does the script.
function(run)
	execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE text ERROR_VARIABLE text)
	if(NOT code EQUAL 0)
		message(FATAL_ERROR "${ARGN}: ${code}\n${text}")
	endif()
	set(text "${text}" PARENT_SCOPE)
endfunction()
