// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Threads for a wish of 0 (all) or more; one where the library is built without OpenMP.
int threadCount(int wanted);
}  // namespace ist
