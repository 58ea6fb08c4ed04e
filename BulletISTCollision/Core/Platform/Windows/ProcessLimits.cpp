// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ProcessLimits.h"

#include "BulletISTCollision/Core/Platform/Windows/EndCodes.h"
#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <psapi.h>

#include <thread>

namespace ist
{
namespace
{
double secondsOf(const FILETIME& time) { return 1e-7 * (4294967296.0 * double(time.dwHighDateTime) + double(time.dwLowDateTime)); }

double processorSeconds()
{
	FILETIME created{}, ended{}, kernel{}, user{};
	::GetProcessTimes(::GetCurrentProcess(), &created, &ended, &kernel, &user);
	return secondsOf(kernel) + secondsOf(user);
}

double ownBytes()
{
	PROCESS_MEMORY_COUNTERS used{};
	used.cb = sizeof used;
	return ::K32GetProcessMemoryInfo(::GetCurrentProcess(), &used, sizeof used) != 0 ? double(used.PagefileUsage) : 0;
}

void limitMemory(double bytes)
{
	const HANDLE job = ::CreateJobObjectW(nullptr, nullptr);
	JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
	limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_PROCESS_MEMORY;
	limits.ProcessMemoryLimit = static_cast<SIZE_T>(bytes);
	// The job lives as long as the process, and so its handle stays open.
	if (job && ::SetInformationJobObject(job, JobObjectExtendedLimitInformation, &limits, sizeof limits) != 0)
		::AssignProcessToJobObject(job, ::GetCurrentProcess());
}
}  // namespace

void limitProcess(double seconds, double memoryShare)
{
	// No dialog when the process breaks down.
	::SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX);
	MEMORYSTATUSEX machine{};
	machine.dwLength = sizeof machine;
	::GlobalMemoryStatusEx(&machine);
	const double bytes = memoryShare * double(machine.ullTotalPhys);
	limitMemory(bytes);
	std::thread([seconds, bytes] {
		for (;; ::Sleep(100))
		{
			if (processorSeconds() > seconds) ::TerminateProcess(::GetCurrentProcess(), kOutOfTimeCode);
			if (ownBytes() > bytes) ::TerminateProcess(::GetCurrentProcess(), kOutOfMemoryCode);
		}
	}).detach();
}
}  // namespace ist
