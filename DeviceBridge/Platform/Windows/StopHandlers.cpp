// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/StopHandlers.h"

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <atomic>
#include <csignal>

namespace devicebridge
{
namespace
{
std::atomic<void (*)(int)> callback{nullptr};
std::atomic<bool> stopped{false};

BOOL WINAPI onEvent(DWORD event)
{
	// The second one goes to the handlers of before; the system's own ends the program.
	if (stopped.exchange(true)) return FALSE;
	if (auto* const stop = callback.load()) stop(event == CTRL_C_EVENT ? SIGINT : SIGTERM);
	return TRUE;
}
}  // namespace

bool installStopHandlers(void (*stop)(int signal))
{
	callback = stop;
	stopped = false;
	return ::SetConsoleCtrlHandler(onEvent, TRUE) != 0;
}

void restoreStopHandlers() { ::SetConsoleCtrlHandler(onEvent, FALSE); }
}  // namespace devicebridge
