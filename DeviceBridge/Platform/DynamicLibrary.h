// SPDX-License-Identifier: Zlib
#pragma once

#include <string>

namespace devicebridge
{
/// A shared library, loaded at run time and never unloaded, because vendors' libraries have threads of their own.
class DynamicLibrary
{
public:
	/// Visibility of the library's symbols. It makes no difference on Windows, where programs ask for them by the library's name.
	enum class Symbols
	{
		Own,    ///< only this object
		Shared  ///< libraries that are loaded later, too
	};

	/// Loads a library by its path, in UTF-8, or by a name that the system searches for. Returns false, with why(), if it cannot be loaded.
	bool load(const std::string& file, Symbols symbols);
	/// The function of this name; null if there is none.
	template <class Function> Function* find(const char* name) const { return reinterpret_cast<Function*>(address(name)); }

	bool isLoaded() const { return m_library != nullptr; }
	/// The system's message about the last load() that failed.
	const std::string& why() const { return m_why; }

private:
	void* address(const char* name) const;

	void* m_library = nullptr;
	std::string m_why;
};

/// Separates the folders of a list in a variable of the environment.
extern const char kFolderSeparator;
/// What the name of a plug-in's file begins and ends with.
extern const char* const kLibraryPrefix;
extern const char* const kLibraryEnding;
/// Variable of the environment with the folders in which the system searches for libraries.
extern const char* const kLibraryFolders;
}  // namespace devicebridge
