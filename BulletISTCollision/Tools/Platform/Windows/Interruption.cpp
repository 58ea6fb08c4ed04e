// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Interruption.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <atomic>

namespace ist::tools
{
namespace
{
std::atomic<bool> caught{false};

/// The system calls it in a thread of its own. A second event ends the program, as if there were no handler.
BOOL WINAPI onEvent(DWORD) { return caught.exchange(true) ? FALSE : TRUE; }
}  // namespace

void catchInterrupts()
{
	// A parent may have switched Ctrl-C off for its children.
	::SetConsoleCtrlHandler(nullptr, FALSE);
	::SetConsoleCtrlHandler(onEvent, TRUE);
}

bool interrupted() { return caught; }
}  // namespace ist::tools
