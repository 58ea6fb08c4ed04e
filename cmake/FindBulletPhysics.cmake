# SPDX-License-Identifier: Zlib
# Bullet Physics in both precisions. Neither Bullet's own config file nor CMake's find module can be used for this: the first
# has relative paths and no targets, the second knows single precision only.
#
#   BulletPhysics::Single   LinearMath, BulletCollision, BulletDynamics with float
#   BulletPhysics::Double   the same with double; defines BT_USE_DOUBLE_PRECISION for its users
#
# Components: Single, Double. Without any, one of the two is enough. Sets BulletPhysics_FOUND, BulletPhysics_<component>_FOUND,
# BulletPhysics_<component>_THREADSAFE, BulletPhysics_VERSION.
#
# BULLET_ROOT: folders that Bullet was installed into; nothing is looked for elsewhere then. Debian calls the libraries of double precision
# Bullet...-float64. Bullet's own build gives both precisions the same names, so each precision needs a folder of its own.
# The symbols of a library tell its precision, and whether it was built for threads (BT_THREADSAFE).
# Users of a library for threads get the same definition, because some of its locks are in headers.

# Whether a library names a symbol that contains this.
function(_bulletphysics_names library symbol result)
	file(STRINGS "${library}" lines REGEX "${symbol}" LIMIT_COUNT 1)
	string(COMPARE NOTEQUAL "${lines}" "" named)
	set(${result} ${named} PARENT_SCOPE)
endfunction()

# The library `name`, found with these options, is BulletDynamics unless its scalar is `other` (f or d, as compilers write it; M and N are
# what Visual Studio writes).
function(_bulletphysics_try component other name)
	if(DEFINED BulletPhysics_${component}_BulletDynamics)
		return()
	endif()
	unset(library)
	find_library(library ${name} ${ARGN} NO_CACHE)
	if(NOT library)
		return()
	endif()
	set(visual_studio_f M)
	set(visual_studio_d N)
	_bulletphysics_names("${library}"
		"btDiscreteDynamicsWorld14stepSimulationE${other}i|stepSimulation@btDiscreteDynamicsWorld@@UEAAH${visual_studio_${other}}H" is_other)
	if(NOT is_other)
		set(BulletPhysics_${component}_BulletDynamics "${library}" CACHE FILEPATH "")
	endif()
endfunction()

function(_bulletphysics_component component other)
	foreach(name IN LISTS ARGN)
		foreach(root IN LISTS BULLET_ROOT)
			_bulletphysics_try(${component} ${other} ${name} PATHS "${root}"
				PATH_SUFFIXES lib lib64 "lib/${CMAKE_LIBRARY_ARCHITECTURE}" NO_DEFAULT_PATH)
		endforeach()
		if(NOT BULLET_ROOT)
			_bulletphysics_try(${component} ${other} ${name})
		endif()
	endforeach()
	set(dynamics "${BulletPhysics_${component}_BulletDynamics}")
	cmake_path(GET dynamics PARENT_PATH folder)
	string(REGEX MATCH "-float64" suffix "${dynamics}")
	# Users before what they use, for static builds.
	set(libraries "${dynamics}")
	foreach(library BulletCollision LinearMath)
		find_library(BulletPhysics_${component}_${library} ${library}${suffix} PATHS "${folder}" NO_DEFAULT_PATH)
		list(APPEND libraries "${BulletPhysics_${component}_${library}}")
	endforeach()
	# Beside the libraries: those of another Bullet may differ in what an object holds.
	find_path(BulletPhysics_${component}_INCLUDE_DIR btBulletDynamicsCommon.h PATHS "${folder}/.." "${folder}/../.."
		PATH_SUFFIXES include/bullet NO_DEFAULT_PATH)
	find_path(BulletPhysics_${component}_INCLUDE_DIR btBulletDynamicsCommon.h PATH_SUFFIXES include/bullet bullet)
	mark_as_advanced(BulletPhysics_${component}_BulletDynamics BulletPhysics_${component}_BulletCollision BulletPhysics_${component}_LinearMath
		BulletPhysics_${component}_INCLUDE_DIR)
	foreach(part BulletDynamics BulletCollision LinearMath INCLUDE_DIR)
		if(NOT BulletPhysics_${component}_${part})
			return()
		endif()
	endforeach()

	_bulletphysics_names("${BulletPhysics_${component}_LinearMath}"
		"btThreadSupportInterface6create|create@btThreadSupportInterface" threadsafe)
	set(BulletPhysics_${component}_FOUND TRUE PARENT_SCOPE)
	set(BulletPhysics_${component}_THREADSAFE ${threadsafe} PARENT_SCOPE)
	if(TARGET BulletPhysics::${component})
		return()
	endif()
	set(definitions "")
	if(component STREQUAL "Double")
		list(APPEND definitions BT_USE_DOUBLE_PRECISION)
	endif()
	if(threadsafe)
		list(APPEND definitions BT_THREADSAFE=1)
	endif()
	add_library(BulletPhysics::${component} INTERFACE IMPORTED)
	set_target_properties(BulletPhysics::${component} PROPERTIES
		INTERFACE_INCLUDE_DIRECTORIES "${BulletPhysics_${component}_INCLUDE_DIR}"
		INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${BulletPhysics_${component}_INCLUDE_DIR}"
		INTERFACE_COMPILE_DEFINITIONS "${definitions}"
		INTERFACE_LINK_LIBRARIES "${libraries}")
endfunction()

_bulletphysics_component(Single d BulletDynamics)
_bulletphysics_component(Double f BulletDynamics-float64 BulletDynamics)

set(BulletPhysics_VERSION "")
set(_bulletphysics_include "")
foreach(_bulletphysics_precision Double Single)
	if(BulletPhysics_${_bulletphysics_precision}_FOUND)
		set(_bulletphysics_include "${BulletPhysics_${_bulletphysics_precision}_INCLUDE_DIR}")
	endif()
endforeach()
if(_bulletphysics_include)
	file(STRINGS "${_bulletphysics_include}/LinearMath/btScalar.h" _bulletphysics_version REGEX "define BT_BULLET_VERSION [0-9]+")
	if(_bulletphysics_version MATCHES "BT_BULLET_VERSION ([0-9]+)")
		math(EXPR _bulletphysics_major "${CMAKE_MATCH_1} / 100")
		math(EXPR _bulletphysics_minor "${CMAKE_MATCH_1} % 100")
		set(BulletPhysics_VERSION "${_bulletphysics_major}.${_bulletphysics_minor}")
	endif()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(BulletPhysics
	REQUIRED_VARS _bulletphysics_include
	VERSION_VAR BulletPhysics_VERSION
	HANDLE_COMPONENTS)
