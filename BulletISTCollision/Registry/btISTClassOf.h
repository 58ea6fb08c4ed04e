// SPDX-License-Identifier: Zlib
#pragma once

#include <cstring>
#if defined(__cpp_rtti)
#include <typeinfo>
#endif

// What class an object of Bullet's has, for programs with and without RTTI. A class that a game compiled with -fno-rtti has no type
// information, and dynamic_cast and typeid would read through a null pointer. Without it, a class is recognised by its virtual table:
// Bullet's own classes are, and a class that a game derived is not.

/// The address of the virtual table of an object: one for each class.
inline const void* btISTVirtualTable(const void* object)
{
	const void* table;
	std::memcpy(&table, object, sizeof table);
	return table;
}

/// Whether the class of an object was compiled with RTTI, and this file, too.
inline bool btISTHasTypeInfo([[maybe_unused]] const void* object)
{
#if !defined(__cpp_rtti)
	return false;
#elif defined(_MSC_VER)
	return true;
#else
	// Itanium C++ ABI: the entry before the first function.
	return static_cast<const void* const*>(btISTVirtualTable(object))[-1] != nullptr;
#endif
}

/// The object as a `To`, or null if it is none. `table` returns the virtual table of a `To`; it is called for objects without type
/// information, of which only those are recognised that are exactly a `To`.
template <class To, class From, class Table> To* btISTCast(From* object, const Table& table)
{
	if (!object) return nullptr;
#if defined(__cpp_rtti)
	if (btISTHasTypeInfo(object)) return dynamic_cast<To*>(object);
#endif
	return btISTVirtualTable(object) == table() ? static_cast<To*>(object) : nullptr;
}

/// Whether an object is a `Class` and of no class derived from it. `Class` has a constructor without arguments.
template <class Class, class Base> bool btISTIsExactly(const Base& object)
{
#if defined(__cpp_rtti)
	if (btISTHasTypeInfo(&object)) return typeid(object) == typeid(Class);
#endif
	Class example;
	return btISTVirtualTable(&object) == btISTVirtualTable(&example);
}
