// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Platform/ChildProcess.h"

#include "BulletISTCollision/Core/Platform/Windows/EndCodes.h"
#include "BulletISTCollision/Core/Platform/Windows/OpenHandle.h"

#include <memory>
#include <utility>

namespace ist
{
namespace
{
HANDLE handleOf(std::intptr_t process) { return reinterpret_cast<HANDLE>(process); }

/// An argument as programs of Windows split them again.
std::wstring quoted(const std::wstring& argument)
{
	std::wstring text = L"\"";
	std::size_t backslashes = 0;
	for (const wchar_t c : argument)
	{
		// Backslashes before a quotation mark count double, and one more keeps the mark as it is.
		if (c == L'"') text.append(backslashes + 1, L'\\');
		text += c;
		backslashes = c == L'\\' ? backslashes + 1 : 0;
	}
	return text.append(backslashes, L'\\') + L'"';
}

/// The list of handles that a process inherits.
class InheritedHandles
{
public:
	bool set(HANDLE* handles, std::size_t count)
	{
		SIZE_T size = 0;
		::InitializeProcThreadAttributeList(nullptr, 1, 0, &size);
		m_memory = std::make_unique<char[]>(size);
		m_made = ::InitializeProcThreadAttributeList(list(), 1, 0, &size) != 0;
		return m_made &&
			::UpdateProcThreadAttribute(list(), 0, PROC_THREAD_ATTRIBUTE_HANDLE_LIST, handles, count * sizeof *handles, nullptr, nullptr) !=
			0;
	}
	InheritedHandles() = default;
	~InheritedHandles()
	{
		if (m_made) ::DeleteProcThreadAttributeList(list());
	}
	InheritedHandles(const InheritedHandles&) = delete;
	InheritedHandles& operator=(const InheritedHandles&) = delete;
	LPPROC_THREAD_ATTRIBUTE_LIST list() { return reinterpret_cast<LPPROC_THREAD_ATTRIBUTE_LIST>(m_memory.get()); }

private:
	std::unique_ptr<char[]> m_memory;
	bool m_made = false;
};

ChildProcess::Status statusOf(HANDLE process)
{
	DWORD code = 0;
	::WaitForSingleObject(process, INFINITE);
	const bool known = ::GetExitCodeProcess(process, &code) != 0;
	::CloseHandle(process);
	if (!known) return {};
	using enum ChildProcess::Ending;
	if (code == STATUS_CONTROL_C_EXIT) return {Interrupted, 0};
	if (code == kOutOfTimeCode) return {OutOfTime, 0};
	if (code == kOutOfMemoryCode) return {OutOfMemory, 0};
	return code >= 0x80000000 ? ChildProcess::Status{Broken, 0} : ChildProcess::Status{Exited, static_cast<int>(code)};
}
}  // namespace

ChildProcess::~ChildProcess()
{
	if (m_process == kNone) return;
	::TerminateProcess(handleOf(m_process), 1);
	(void)wait();
}

std::error_code ChildProcess::start(const std::vector<std::string>& arguments, const PipeEnd& output)
{
	std::wstring line;
	for (const std::string& argument : arguments) line += (line.empty() ? L"" : L" ") + quoted(wide(argument));
	SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
	const OpenHandle nothing(
		::CreateFileW(L"NUL", GENERIC_READ | GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE, &inherited, OPEN_EXISTING, 0, nullptr));
	HANDLE copy = nullptr;
	if (!nothing.good() ||
		::DuplicateHandle(::GetCurrentProcess(), handleOf(output.m_end), ::GetCurrentProcess(), &copy, 0, TRUE, DUPLICATE_SAME_ACCESS) == 0)
		return lastError();
	const OpenHandle sending(copy);
	HANDLE handles[] = {sending.get(), nothing.get()};
	InheritedHandles list;
	if (!list.set(handles, 2)) return lastError();
	STARTUPINFOEXW settings{};
	settings.StartupInfo.cb = sizeof settings;
	settings.StartupInfo.dwFlags = STARTF_USESTDHANDLES;
	settings.StartupInfo.hStdInput = settings.StartupInfo.hStdError = nothing.get();
	settings.StartupInfo.hStdOutput = sending.get();
	settings.lpAttributeList = list.list();
	PROCESS_INFORMATION started{};
	if (::CreateProcessW(wide(arguments.front()).c_str(), line.data(), nullptr, nullptr, TRUE,
			CREATE_NO_WINDOW | EXTENDED_STARTUPINFO_PRESENT, nullptr, nullptr, &settings.StartupInfo, &started) == 0)
		return lastError();
	::CloseHandle(started.hThread);
	m_process = reinterpret_cast<std::intptr_t>(started.hProcess);
	return {};
}

ChildProcess::Status ChildProcess::wait() { return statusOf(handleOf(std::exchange(m_process, kNone))); }
}  // namespace ist
