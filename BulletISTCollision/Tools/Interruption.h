// SPDX-License-Identifier: Zlib
#pragma once

namespace ist::tools
{
/// Ctrl-C and a polite kill end the work at its next progress call, so that no half file stays. A second one ends the program
/// at once.
void catchInterrupts();
bool interrupted();
}  // namespace ist::tools
