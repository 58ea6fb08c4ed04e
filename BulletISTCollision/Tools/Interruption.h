// SPDX-License-Identifier: Zlib
#pragma once

namespace ist::tools
{
/// Makes SIGINT (Ctrl-C) and SIGTERM end the work at its next progress call, so that no incomplete file is left. A second signal ends the
/// program at once.
void catchInterrupts();
bool interrupted();
}  // namespace ist::tools
