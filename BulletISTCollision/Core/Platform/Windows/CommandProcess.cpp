// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/CommandProcess.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <shellapi.h>

namespace ist
{
std::vector<std::string> commandArguments(int argc, char** argv)
{
	// Those of main() are in the code page of the user, which lacks most characters.
	int count = 0;
	wchar_t** const wideArguments = ::CommandLineToArgvW(::GetCommandLineW(), &count);
	if (!wideArguments) return {argv, argv + argc};
	std::vector<std::string> arguments;
	for (int i = 0; i < count; ++i) arguments.push_back(narrow(wideArguments[i]));
	::LocalFree(wideArguments);
	return arguments;
}

void prepareCommand() { ::SetConsoleOutputCP(CP_UTF8); }
}  // namespace ist
