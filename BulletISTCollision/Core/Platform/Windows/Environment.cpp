// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/Environment.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

namespace ist
{
std::optional<std::string> environmentValue(const char* name)
{
	const std::wstring wideName = wide(name);
	std::wstring value;
	for (DWORD size = 256;;)
	{
		value.resize(size);
		::SetLastError(ERROR_SUCCESS);
		const DWORD needed = ::GetEnvironmentVariableW(wideName.c_str(), value.data(), size);
		if (needed == 0 && ::GetLastError() == ERROR_ENVVAR_NOT_FOUND) return std::nullopt;
		if (needed < size) return narrow(std::wstring_view(value).substr(0, needed));
		size = needed;
	}
}

void setEnvironmentDefault(const char* name, const char* value)
{
	// By the C library, which tells the system, too: other libraries ask either.
	if (!environmentValue(name)) ::_wputenv_s(wide(name).c_str(), wide(value).c_str());
}
}  // namespace ist
