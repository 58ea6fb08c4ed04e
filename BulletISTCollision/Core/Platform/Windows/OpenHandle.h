// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Platform/Windows/WideText.h"

#include <utility>

namespace ist
{
/// A handle of the system, which is closed with this object.
class OpenHandle
{
public:
	explicit OpenHandle(HANDLE handle = INVALID_HANDLE_VALUE) : m_handle(handle) {}
	~OpenHandle() { close(); }
	OpenHandle(const OpenHandle&) = delete;
	OpenHandle& operator=(const OpenHandle&) = delete;

	bool good() const { return m_handle != INVALID_HANDLE_VALUE && m_handle != nullptr; }
	HANDLE get() const { return m_handle; }
	bool close()
	{
		const bool wasGood = good();
		const HANDLE handle = release();
		return !wasGood || ::CloseHandle(handle) != 0;
	}
	/// Passes the handle on; it is no longer closed.
	HANDLE release() { return std::exchange(m_handle, INVALID_HANDLE_VALUE); }

private:
	HANDLE m_handle;
};
}  // namespace ist
