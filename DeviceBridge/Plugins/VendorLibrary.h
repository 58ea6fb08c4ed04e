// SPDX-License-Identifier: Zlib
#pragma once

#include <dlfcn.h>

#include <cstdlib>
#include <initializer_list>
#include <string>

namespace devicebridge::plugin
{
/// A vendor's shared library, found at run time and never unloaded. If the environment variable is set, it gives the file.
class VendorLibrary
{
public:
	VendorLibrary(const char* variable, std::initializer_list<const char*> names)
	{
		const char* const file = std::getenv(variable);
		if (file) open(file);
		for (const char* name : names)
			if (!file && !m_library) open(name);
		if (!m_library)
			m_why += "; install the vendor's software, add its folder to LD_LIBRARY_PATH or name the file in " + std::string(variable);
	}

	/// Looks up a function. It is null if the symbol is missing, and why() names the first missing symbol.
	template <class Function> void find(const char* symbol, Function*& function)
	{
		function = m_library ? reinterpret_cast<Function*>(dlsym(m_library, symbol)) : nullptr;
		if (m_library && !function && m_why.empty()) m_why = m_file + " lacks the function " + symbol;
	}
	/// What is missing; empty if everything was found.
	const std::string& why() const { return m_why; }

private:
	void open(const char* file)
	{
		m_file = file;
		m_library = dlopen(file, RTLD_NOW | RTLD_GLOBAL | RTLD_NODELETE);
		if (m_library) m_why.clear();
		else m_why += (m_why.empty() ? "" : "; ") + std::string(dlerror());
	}

	std::string m_file, m_why;
	void* m_library = nullptr;
};
}  // namespace devicebridge::plugin
