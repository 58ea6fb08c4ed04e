// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Between two looks of a thread that waits spinning: leaves the core to its other thread, and saves power.
inline void spinPause()
{
#if defined(__x86_64__)
	__builtin_ia32_pause();
#endif
}
}  // namespace ist
