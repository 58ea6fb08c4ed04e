// SPDX-License-Identifier: Zlib
#pragma once

namespace ist::tools
{
/// Whether standard error is a terminal that obeys escape sequences.
bool hasTerminal();
/// Columns of this terminal; 80 if it does not say.
int terminalWidth();
}  // namespace ist::tools
