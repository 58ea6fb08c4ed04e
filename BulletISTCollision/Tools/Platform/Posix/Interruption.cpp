// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Tools/Interruption.h"

#include <csignal>

namespace ist::tools
{
namespace
{
volatile std::sig_atomic_t caught = 0;

void onSignal(int) { caught = 1; }
}  // namespace

void catchInterrupts()
{
	struct sigaction action = {};
	action.sa_handler = onSignal;
	action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
	sigaction(SIGINT, &action, nullptr);
	sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return caught != 0; }
}  // namespace ist::tools
