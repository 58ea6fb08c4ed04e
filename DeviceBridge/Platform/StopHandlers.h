// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
/// Calls `stop` with the number of the signal when SIGINT or SIGTERM comes; on Windows, in a thread of its own, when the user presses
/// Ctrl-C (SIGINT), or Ctrl-Break, closes the console or logs off (SIGTERM). A second signal goes to the handlers of before. Returns false
/// if the system refuses.
bool installStopHandlers(void (*stop)(int signal));
/// Restores the handlers of before.
void restoreStopHandlers();
}  // namespace devicebridge
