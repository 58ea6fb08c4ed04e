// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Platform/PipeEnd.h"

#include <string>
#include <system_error>
#include <vector>

namespace ist
{
/// A program that this process has started. It is ended with this object.
class ChildProcess
{
public:
	/// How a program ended.
	enum class Ending
	{
		Exited,       ///< by itself
		Interrupted,  ///< the user or the system asked it to end
		OutOfTime,    ///< it reached a limit of limitProcess()
		OutOfMemory,
		Broken  ///< by a fault
	};
	struct Status
	{
		Ending ending = Ending::Exited;
		int code = 0;  ///< what it exited with
	};

	ChildProcess() = default;
	~ChildProcess();
	ChildProcess(const ChildProcess&) = delete;
	ChildProcess& operator=(const ChildProcess&) = delete;

	/// Starts a program: its path and its arguments, in UTF-8. Its output goes into the pipe and its messages nowhere. It inherits no other
	/// file, and no signal is blocked or ignored in it. Returns why it cannot be started.
	std::error_code start(const std::vector<std::string>& arguments, const PipeEnd& output);
	/// Waits for its end. Code 0 if this program waits for its children elsewhere.
	Status wait();

private:
	static constexpr std::intptr_t kNone = 0;
	std::intptr_t m_process = kNone;
};

/// Exit code of a process that found no program to run (Posix only: there the process exists before it is the program's).
constexpr int kNotRunCode = 127;
}  // namespace ist
