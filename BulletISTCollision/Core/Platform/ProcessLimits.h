// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Limits the processor time of this process [s], and its memory to a share of the machine's. Beyond the first, the process ends, and
/// beyond the second, allocations fail; ChildProcess tells its parent why. It closes files that the process inherited, and leaves no dump
/// and no window behind if the process breaks down.
/// Windows: a thread looks ten times a second, and ends the process, also for its memory where the system does not limit that.
void limitProcess(double seconds, double memoryShare);
}  // namespace ist
