// SPDX-License-Identifier: Zlib
#pragma once

#include <dlfcn.h>

#include <cstdlib>
#include <initializer_list>
#include <string>

namespace devicebridge::plugin
{
/// A vendor's shared library, found at run time and never unloaded. The environment variable, when set, names the file instead.
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

	/// Null, and why() names the first symbol that was not there.
	template <class Function> void find(const char* symbol, Function*& function)
	{
		function = m_library ? reinterpret_cast<Function*>(dlsym(m_library, symbol)) : nullptr;
		if (m_library && !function && m_why.empty()) m_why = m_file + " lacks the function " + symbol;
	}
	/// What is missing; empty when all was found.
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
