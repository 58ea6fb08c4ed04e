# SPDX-License-Identifier: Zlib
# Bullet Physics in both precisions. Neither Bullet's own config file nor CMake's find module can be used for this: the first
# has relative paths and no targets, the second knows single precision only.
#
#   BulletPhysics::Single   LinearMath, BulletCollision, BulletDynamics with float
#   BulletPhysics::Double   the same with double; defines BT_USE_DOUBLE_PRECISION for its users
#
# Components: Single, Double. Without any, one of the two is enough. Sets BulletPhysics_FOUND, BulletPhysics_<component>_FOUND,
# BulletPhysics_VERSION. Hint: BULLET_ROOT.

find_path(BulletPhysics_INCLUDE_DIR btBulletDynamicsCommon.h HINTS ${BULLET_ROOT} PATH_SUFFIXES include/bullet bullet)

set(BulletPhysics_VERSION "")
if(BulletPhysics_INCLUDE_DIR)
	file(STRINGS "${BulletPhysics_INCLUDE_DIR}/LinearMath/btScalar.h" _bulletphysics_version REGEX "define BT_BULLET_VERSION [0-9]+")
	if(_bulletphysics_version MATCHES "BT_BULLET_VERSION ([0-9]+)")
		math(EXPR _bulletphysics_major "${CMAKE_MATCH_1} / 100")
		math(EXPR _bulletphysics_minor "${CMAKE_MATCH_1} % 100")
		set(BulletPhysics_VERSION "${_bulletphysics_major}.${_bulletphysics_minor}")
	endif()
endif()

function(_bulletphysics_component component suffix)
	set(libraries)
	# Users before what they use, for static builds.
	foreach(library BulletDynamics BulletCollision LinearMath)
		find_library(BulletPhysics_${component}_${library} ${library}${suffix} HINTS ${BULLET_ROOT} PATH_SUFFIXES lib)
		mark_as_advanced(BulletPhysics_${component}_${library})
		if(NOT BulletPhysics_${component}_${library})
			return()
		endif()
		list(APPEND libraries "${BulletPhysics_${component}_${library}}")
	endforeach()
	if(NOT BulletPhysics_INCLUDE_DIR)
		return()
	endif()
	set(BulletPhysics_${component}_FOUND TRUE PARENT_SCOPE)
	if(NOT TARGET BulletPhysics::${component})
		add_library(BulletPhysics::${component} INTERFACE IMPORTED)
		set_target_properties(BulletPhysics::${component} PROPERTIES
			INTERFACE_INCLUDE_DIRECTORIES "${BulletPhysics_INCLUDE_DIR}"
			INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${BulletPhysics_INCLUDE_DIR}"
			INTERFACE_LINK_LIBRARIES "${libraries}")
		if(component STREQUAL "Double")
			set_target_properties(BulletPhysics::Double PROPERTIES INTERFACE_COMPILE_DEFINITIONS BT_USE_DOUBLE_PRECISION)
		endif()
	endif()
endfunction()

_bulletphysics_component(Single "")
_bulletphysics_component(Double "-float64")

set(_bulletphysics_any "")
if(BulletPhysics_Single_FOUND OR BulletPhysics_Double_FOUND)
	set(_bulletphysics_any TRUE)
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(BulletPhysics
	REQUIRED_VARS BulletPhysics_INCLUDE_DIR _bulletphysics_any
	VERSION_VAR BulletPhysics_VERSION
	HANDLE_COMPONENTS)
mark_as_advanced(BulletPhysics_INCLUDE_DIR)
