// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/CommandProcess.h"

#include <csignal>

namespace ist
{
std::vector<std::string> commandArguments(int argc, char** argv) { return {argv, argv + argc}; }

void prepareCommand() { std::signal(SIGXFSZ, SIG_IGN); }
}  // namespace ist
