// SPDX-License-Identifier: Zlib
#pragma once

#define XR_USE_TIMESPEC
#include <time.h>

#include <memory>
#include <mutex>
#include <string>

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include "BulletISTCollision/Core/Base/Result.h"

namespace devicebridge
{
/// The program's session with the OpenXR runtime, without graphics. Both hands share one session, because many runtimes allow only one. Any
/// thread may call it.
class OpenXrSession
{
public:
	struct Functions
	{
		PFN_xrCreateHandTrackerEXT createHandTracker = nullptr;
		PFN_xrDestroyHandTrackerEXT destroyHandTracker = nullptr;
		PFN_xrLocateHandJointsEXT locateHandJoints = nullptr;
		PFN_xrConvertTimespecTimeToTimeKHR convertTime = nullptr;
	};

	/// The existing session, or a new one.
	static ist::Result<std::shared_ptr<OpenXrSession>> shared();
	~OpenXrSession();

	/// Processes the runtime's events. Returns an empty string while the session runs or is about to; otherwise a sentence that says why it
	/// has ended.
	std::string poll();
	/// Present time of the runtime's clock; zero if it is unknown.
	XrTime now() const;
	XrSession session() const { return m_session; }
	XrSpace space() const { return m_space; }
	const Functions& functions() const { return m_functions; }
	const std::string& runtimeName() const { return m_runtimeName; }

private:
	OpenXrSession() = default;
	std::string open();
	std::string createInstance();
	std::string createSession();
	void changeState(XrSessionState state);

	std::mutex m_mutex;  // guards poll()
	XrInstance m_instance = XR_NULL_HANDLE;
	XrSession m_session = XR_NULL_HANDLE;
	XrSpace m_space = XR_NULL_HANDLE;
	Functions m_functions;
	std::string m_runtimeName, m_ended;
	bool m_running = false;
};

/// The name "XR_ERROR_..." or the number.
std::string openXrError(XrInstance instance, XrResult result);
}  // namespace devicebridge
