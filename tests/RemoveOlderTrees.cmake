# SPDX-License-Identifier: Zlib
# Removes the trees in FOLDER that are not newer than the library BUILDER.
file(GLOB trees "${FOLDER}/*.ist")
foreach(tree IN LISTS trees)
	if("${BUILDER}" IS_NEWER_THAN "${tree}")
		file(REMOVE "${tree}")
	endif()
endforeach()
