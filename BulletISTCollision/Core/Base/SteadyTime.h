// SPDX-License-Identifier: Zlib
#pragma once

#include <chrono>

namespace ist
{
/// Monotonic time [us].
inline double steadyMicroseconds()
{
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
}  // namespace ist
