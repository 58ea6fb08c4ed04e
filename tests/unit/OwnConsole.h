// SPDX-License-Identifier: Zlib
#pragma once

#include <gtest/gtest.h>

// clang-format off: the others need windows.h
#include <windows.h>
// clang-format on

#include <cstdlib>
#include <string>
#include <vector>

namespace devicebridge
{
/// A program that was started on Windows. The destructor ends it.
class StartedProgram
{
public:
	/// `flags` are those of CreateProcess.
	explicit StartedProgram(const std::string& commandLine, DWORD flags = 0)
	{
		std::vector<char> line(commandLine.begin(), commandLine.end());
		line.push_back('\0');
		STARTUPINFOA start{};
		start.cb = sizeof start;
		start.dwFlags = STARTF_USESTDHANDLES;
		start.hStdOutput = ::GetStdHandle(STD_OUTPUT_HANDLE);
		start.hStdError = ::GetStdHandle(STD_ERROR_HANDLE);
		PROCESS_INFORMATION started{};
		if (::CreateProcessA(nullptr, line.data(), nullptr, nullptr, TRUE, flags, nullptr, nullptr, &start, &started) == 0) return;
		::CloseHandle(started.hThread);
		m_process = started.hProcess;
	}
	~StartedProgram()
	{
		if (!m_process) return;
		::TerminateProcess(m_process, 1);
		::CloseHandle(m_process);
	}
	StartedProgram(const StartedProgram&) = delete;
	StartedProgram& operator=(const StartedProgram&) = delete;

	/// Exit code once the program has ended; STILL_ACTIVE if it has not after a minute, or was not started.
	unsigned long exitCode() const
	{
		DWORD code = STILL_ACTIVE;
		if (m_process && ::WaitForSingleObject(m_process, 60'000) == WAIT_OBJECT_0) ::GetExitCodeProcess(m_process, &code);
		return code;
	}

private:
	HANDLE m_process = nullptr;
};

/// Whether this process was started by runTestInOwnConsole(): Ctrl-C then reaches it and the programs that it starts, and no others.
inline bool hasOwnConsole() { return std::getenv("TEST_IN_OWN_CONSOLE") != nullptr; }

/// Runs the present test again, in a process with a console of its own. Returns its exit code.
inline unsigned long runTestInOwnConsole()
{
	const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
	char program[1024];
	::GetModuleFileNameA(nullptr, program, sizeof program);
	::SetEnvironmentVariableA("TEST_IN_OWN_CONSOLE", "1");
	const StartedProgram run(
		"\"" + std::string(program) + "\" --gtest_brief=1 --gtest_filter=" + test.test_suite_name() + "." + test.name(), CREATE_NO_WINDOW);
	::SetEnvironmentVariableA("TEST_IN_OWN_CONSOLE", nullptr);
	return run.exitCode();
}

/// Presses Ctrl-C in the console of this process.
inline bool pressCtrlC() { return ::GenerateConsoleCtrlEvent(CTRL_C_EVENT, 0) != 0; }

/// Whether Ctrl-C is ignored by this process and by programs that it starts from now on.
inline void ignoreCtrlC(bool ignored) { ::SetConsoleCtrlHandler(nullptr, ignored ? TRUE : FALSE); }
}  // namespace devicebridge
