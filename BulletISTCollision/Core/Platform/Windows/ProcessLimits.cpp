// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ProcessLimits.h"

#include "BulletISTCollision/Core/Platform/Windows/EndCodes.h"
#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <psapi.h>

#include <algorithm>
#include <atomic>
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

double machineBytes()
{
	MEMORYSTATUSEX machine{};
	machine.dwLength = sizeof machine;
	::GlobalMemoryStatusEx(&machine);
	return double(machine.ullTotalPhys);
}

/// The job that limits the memory of this process, and the thread that looks whether the process keeps its limits. It lives as long as the
/// process.
class Watch
{
public:
	Watch(double seconds, double bytes) : m_seconds(seconds), m_bytes(bytes)
	{
		limitMemory(bytes);
		if (m_job) ::AssignProcessToJobObject(m_job, ::GetCurrentProcess());
		std::thread([this] {
			for (;; ::Sleep(100))
			{
				if (processorSeconds() > m_seconds) ::TerminateProcess(::GetCurrentProcess(), kOutOfTimeCode);
				if (ownBytes() > m_bytes) ::TerminateProcess(::GetCurrentProcess(), kOutOfMemoryCode);
			}
		}).detach();
	}
	void limit(double seconds, double bytes)
	{
		m_seconds = seconds;
		m_bytes = bytes;
		limitMemory(bytes);
	}

private:
	void limitMemory(double bytes)
	{
		JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
		limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_PROCESS_MEMORY;
		limits.ProcessMemoryLimit = static_cast<SIZE_T>(bytes);
		if (m_job) ::SetInformationJobObject(m_job, JobObjectExtendedLimitInformation, &limits, sizeof limits);
	}

	const HANDLE m_job = ::CreateJobObjectW(nullptr, nullptr);
	std::atomic<double> m_seconds, m_bytes;
};
}  // namespace

void isolateProcess()
{
	// No dialog when the process breaks down.
	::SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX);
}

void limitProcess(double seconds, double bytes)
{
	const double most = std::min(bytes, kMemoryShare * machineBytes());
	static Watch* const watch = new Watch(seconds, most);  // its thread uses it until the process ends
	watch->limit(seconds, most);
}
}  // namespace ist
