// SPDX-License-Identifier: Zlib
#pragma once

#include <initializer_list>
#include <optional>
#include <string>

#include "BulletISTCollision/Core/Platform/Environment.h"
#include "DeviceBridge/Platform/DynamicLibrary.h"

namespace devicebridge::plugin
{
/// A vendor's shared library, found at run time and never unloaded. If the environment variable is set, it gives the file.
class VendorLibrary
{
public:
	/// `names`: what the library is called on all systems; those of other systems are not looked for.
	VendorLibrary(const char* variable, std::initializer_list<const char*> names)
	{
		const std::optional<std::string> file = ist::environmentValue(variable);
		if (file) open(*file);
		for (const std::string name : names)
			if (!file && !m_library.isLoaded() && name.find(kLibraryEnding) != name.npos) open(name);
		if (!m_library.isLoaded())
			m_why += "; install the vendor's software, add its folder to " + std::string(kLibraryFolders) + " or name the file in " +
				variable;
	}

	/// Looks up a function. It is null if the symbol is missing, and why() names the first missing symbol.
	template <class Function> void find(const char* symbol, Function*& function)
	{
		function = m_library.isLoaded() ? m_library.find<Function>(symbol) : nullptr;
		if (m_library.isLoaded() && !function && m_why.empty()) m_why = m_file + " lacks the function " + symbol;
	}
	/// What is missing; empty if everything was found.
	const std::string& why() const { return m_why; }

private:
	void open(const std::string& file)
	{
		m_file = file;
		if (m_library.load(file, DynamicLibrary::Symbols::Shared)) m_why.clear();
		else m_why += (m_why.empty() ? "" : "; ") + m_library.why();
	}

	std::string m_file, m_why;
	DynamicLibrary m_library;
};
}  // namespace devicebridge::plugin
