// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Threads for a wish of 0 (all) or more: no more than 64 or the processors that there are, whichever is more, since each takes megabytes
/// and those without a processor save no time. One where the library is built without OpenMP.
int threadCount(int wanted);
}  // namespace ist
