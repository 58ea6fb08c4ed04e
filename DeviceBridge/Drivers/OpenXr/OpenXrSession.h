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
/// The program's session with the OpenXR runtime, without graphics: both hands share one, since many runtimes have no second. Calls
/// may come from any thread.
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

	/// The one that lives, or a new one.
	static ist::Result<std::shared_ptr<OpenXrSession>> shared();
	~OpenXrSession();

	/// Takes the runtime's events. Empty while the session runs or is about to; else, in a sentence, why it has ended.
	std::string poll();
	/// Now, in the runtime's time; zero when it cannot tell.
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

	std::mutex m_mutex;  // of poll()
	XrInstance m_instance = XR_NULL_HANDLE;
	XrSession m_session = XR_NULL_HANDLE;
	XrSpace m_space = XR_NULL_HANDLE;
	Functions m_functions;
	std::string m_runtimeName, m_ended;
	bool m_running = false;
};

/// "XR_ERROR_..." or the number.
std::string openXrError(XrInstance instance, XrResult result);
}  // namespace devicebridge
