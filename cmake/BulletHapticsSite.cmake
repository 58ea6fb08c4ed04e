# SPDX-License-Identifier: Zlib
# cmake --build build/release --target site: the pages and interfaces as a site, build/release/site/html/index.html.
find_package(Doxygen QUIET)
if(NOT DOXYGEN_FOUND)
	message(STATUS "No target site: it needs doxygen")
	return()
endif()
configure_file(docs/Doxyfile.in Doxyfile @ONLY)
add_custom_target(site COMMAND Doxygen::doxygen ${CMAKE_CURRENT_BINARY_DIR}/Doxyfile VERBATIM)
if(BULLETHAPTICS_TESTS AND NOT BULLETHAPTICS_SANITIZE)
	add_test(NAME docs_site
		COMMAND python3 ${CMAKE_CURRENT_SOURCE_DIR}/tests/docs/run_site.py
			$<TARGET_FILE:Doxygen::doxygen> ${CMAKE_CURRENT_BINARY_DIR}/Doxyfile ${CMAKE_CURRENT_BINARY_DIR}/site/html)
	set_tests_properties(docs_site PROPERTIES LABELS slow)
endif()
