// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Number of threads for a request of 0 (all processors) or more. At most 64 or the number of processors, whichever is larger: each
/// thread takes megabytes, and threads without a processor save no time. 1 if the library is built without OpenMP.
int threadCount(int wanted);
}  // namespace ist
