// SPDX-License-Identifier: Zlib
#pragma once

namespace ist
{
/// Closes files that the process inherited, and has it leave no dump and no window behind if it breaks down. Call it first.
void isolateProcess();

/// Limits the processor time of this process [s] and its memory [bytes]: to three quarters of the machine's at most, and never beyond the
/// limits that it began with. Beyond the first, the process ends, and beyond the second, allocations fail; ChildProcess tells its parent
/// why. A later call replaces the limits, also by larger ones. Call it from one thread.
/// Windows: a thread looks ten times a second, and ends the process, also for its memory where the system does not limit that.
void limitProcess(double seconds, double bytes);

/// Share of the machine's memory that a process may take.
constexpr double kMemoryShare = 0.75;
}  // namespace ist
