// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Platform/Terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

namespace ist::tools
{
bool hasTerminal() { return isatty(STDERR_FILENO) == 1; }

int terminalWidth()
{
	winsize size{};
	return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}
}  // namespace ist::tools
