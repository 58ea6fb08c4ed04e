// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Platform/StopHandlers.h"

#include <csignal>

namespace devicebridge
{
namespace
{
// A signal handler can only reach global variables.
void (*callback)(int) = nullptr;
struct sigaction before[2];
constexpr int kSignals[2] = {SIGINT, SIGTERM};

void onStopSignal(int number)
{
	callback(number);
	for (int i = 0; i < 2; ++i)
		if (kSignals[i] == number) sigaction(number, &before[i], nullptr);
}
}  // namespace

bool installStopHandlers(void (*stop)(int signal))
{
	callback = stop;
	struct sigaction action = {};
	action.sa_handler = onStopSignal;
	action.sa_flags = SA_RESTART;
	return sigaction(SIGINT, &action, &before[0]) == 0 && sigaction(SIGTERM, &action, &before[1]) == 0;
}

void restoreStopHandlers()
{
	for (int i = 0; i < 2; ++i) sigaction(kSignals[i], &before[i], nullptr);
}
}  // namespace devicebridge
