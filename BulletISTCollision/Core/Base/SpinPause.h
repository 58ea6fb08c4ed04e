// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Pause in the loop of a spinning thread. It leaves the core to the other hardware thread and saves power.
inline void spinPause()
{
#if defined(__x86_64__)
	__builtin_ia32_pause();
#endif
}
}  // namespace ist
