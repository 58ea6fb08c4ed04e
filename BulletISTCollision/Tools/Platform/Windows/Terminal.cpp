// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Platform/Terminal.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

namespace ist::tools
{
bool hasTerminal()
{
	const HANDLE console = ::GetStdHandle(STD_ERROR_HANDLE);
	DWORD mode = 0;
	return ::GetConsoleMode(console, &mode) != 0 && ::SetConsoleMode(console, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0;
}

int terminalWidth()
{
	CONSOLE_SCREEN_BUFFER_INFO about{};
	if (::GetConsoleScreenBufferInfo(::GetStdHandle(STD_ERROR_HANDLE), &about) == 0) return 80;
	const int columns = about.srWindow.Right - about.srWindow.Left + 1;
	return columns > 0 ? columns : 80;
}
}  // namespace ist::tools
