// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/OpenXr/OpenXrSession.h"

#include <cstring>
#include <iterator>
#include <vector>

namespace devicebridge
{
namespace
{
constexpr const char* kExtensions[] = {
	XR_EXT_HAND_TRACKING_EXTENSION_NAME, XR_MND_HEADLESS_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};

/// The first extension that the runtime lacks; empty if it has all.
std::string missingExtension()
{
	std::uint32_t count = 0;
	if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr))) return {};
	std::vector<XrExtensionProperties> properties(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, "", 0});
	if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, properties.data()))) return {};
	for (const char* wanted : kExtensions)
	{
		bool found = false;
		for (const XrExtensionProperties& p : properties) found |= std::strcmp(p.extensionName, wanted) == 0;
		if (!found) return wanted;
	}
	return {};
}

template <class Function> bool find(XrInstance instance, const char* name, Function& function)
{
	return XR_SUCCEEDED(xrGetInstanceProcAddr(instance, name, reinterpret_cast<PFN_xrVoidFunction*>(&function)));
}
}  // namespace

std::string openXrError(XrInstance instance, XrResult result)
{
	char text[XR_MAX_RESULT_STRING_SIZE] = "";
	if (instance != XR_NULL_HANDLE && XR_SUCCEEDED(xrResultToString(instance, result, text))) return text;
	return "error " + std::to_string(result);
}

ist::Result<std::shared_ptr<OpenXrSession>> OpenXrSession::shared()
{
	static std::mutex mutex;
	static std::weak_ptr<OpenXrSession> living;
	const std::lock_guard<std::mutex> lock(mutex);
	if (auto session = living.lock())
		if (session->poll().empty()) return session;
	std::shared_ptr<OpenXrSession> session(new OpenXrSession);
	const std::string failure = session->open();
	if (!failure.empty()) return ist::Error{failure, false};
	living = session;
	return session;
}

std::string OpenXrSession::open()
{
	const std::string failure = createInstance();
	return failure.empty() ? createSession() : failure;
}

std::string OpenXrSession::createInstance()
{
	const std::string missing = missingExtension();
	if (!missing.empty()) return "the OpenXR runtime lacks the extension " + missing;
	XrInstanceCreateInfo create{};
	create.type = XR_TYPE_INSTANCE_CREATE_INFO;
	std::strcpy(create.applicationInfo.applicationName, "DeviceBridge");
	create.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
	create.enabledExtensionCount = static_cast<std::uint32_t>(std::size(kExtensions));
	create.enabledExtensionNames = kExtensions;
	const XrResult result = xrCreateInstance(&create, &m_instance);
	if (XR_FAILED(result))
	{
		m_instance = XR_NULL_HANDLE;
		return "no OpenXR runtime (" + openXrError(m_instance, result) +
			"); install one, for instance Monado, and start it, or name it in XR_RUNTIME_JSON";
	}
	XrInstanceProperties properties{};
	properties.type = XR_TYPE_INSTANCE_PROPERTIES;
	if (XR_SUCCEEDED(xrGetInstanceProperties(m_instance, &properties))) m_runtimeName = properties.runtimeName;
	Functions& f = m_functions;
	if (find(m_instance, "xrCreateHandTrackerEXT", f.createHandTracker) &&
		find(m_instance, "xrDestroyHandTrackerEXT", f.destroyHandTracker) &&
		find(m_instance, "xrLocateHandJointsEXT", f.locateHandJoints) && find(m_instance, "xrConvertTimespecTimeToTimeKHR", f.convertTime))
		return {};
	return "the OpenXR runtime lacks a function of hand tracking";
}

std::string OpenXrSession::createSession()
{
	XrSystemGetInfo get{};
	get.type = XR_TYPE_SYSTEM_GET_INFO;
	get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
	XrSystemId system = XR_NULL_SYSTEM_ID;
	XrResult result = xrGetSystem(m_instance, &get, &system);
	if (XR_FAILED(result)) return "the OpenXR runtime has no headset (" + openXrError(m_instance, result) + ")";
	XrSystemHandTrackingPropertiesEXT tracking{};
	tracking.type = XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT;
	XrSystemProperties properties{};
	properties.type = XR_TYPE_SYSTEM_PROPERTIES;
	properties.next = &tracking;
	if (XR_FAILED(xrGetSystemProperties(m_instance, system, &properties)) || !tracking.supportsHandTracking)
		return "the headset of the OpenXR runtime tracks no hands";
	XrSessionCreateInfo create{};
	create.type = XR_TYPE_SESSION_CREATE_INFO;
	create.systemId = system;
	result = xrCreateSession(m_instance, &create, &m_session);
	if (XR_FAILED(result)) return "the OpenXR runtime opens no session (" + openXrError(m_instance, result) + ")";
	XrReferenceSpaceCreateInfo reference{};
	reference.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO;
	reference.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
	reference.poseInReferenceSpace.orientation.w = 1;
	result = xrCreateReferenceSpace(m_session, &reference, &m_space);
	return XR_FAILED(result) ? "the OpenXR runtime has no local space (" + openXrError(m_instance, result) + ")" : std::string();
}

OpenXrSession::~OpenXrSession()
{
	if (m_running) xrEndSession(m_session);
	if (m_space != XR_NULL_HANDLE) xrDestroySpace(m_space);
	if (m_session != XR_NULL_HANDLE) xrDestroySession(m_session);
	if (m_instance != XR_NULL_HANDLE) xrDestroyInstance(m_instance);
}

void OpenXrSession::changeState(XrSessionState state)
{
	if (state == XR_SESSION_STATE_READY && !m_running)
	{
		XrSessionBeginInfo begin{};
		begin.type = XR_TYPE_SESSION_BEGIN_INFO;
		// Some runtimes require a view configuration also without graphics.
		begin.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
		m_running = XR_SUCCEEDED(xrBeginSession(m_session, &begin));
	}
	if (state == XR_SESSION_STATE_STOPPING && m_running)
	{
		xrEndSession(m_session);
		m_running = false;
	}
	if (state == XR_SESSION_STATE_LOSS_PENDING) m_ended = "the OpenXR runtime has lost the headset";
	if (state == XR_SESSION_STATE_EXITING) m_ended = "the OpenXR runtime wants its sessions to end";
}

std::string OpenXrSession::poll()
{
	const std::lock_guard<std::mutex> lock(m_mutex);
	while (m_ended.empty())
	{
		XrEventDataBuffer event{};
		event.type = XR_TYPE_EVENT_DATA_BUFFER;
		const XrResult result = xrPollEvent(m_instance, &event);
		if (result == XR_EVENT_UNAVAILABLE) break;
		if (XR_FAILED(result)) m_ended = "the OpenXR runtime has gone (" + openXrError(m_instance, result) + ")";
		else if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
			changeState(reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state);
		else if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) m_ended = "the OpenXR runtime is about to end";
	}
	return m_ended;
}

XrTime OpenXrSession::now() const
{
	timespec t{};
	clock_gettime(CLOCK_MONOTONIC, &t);
	XrTime time = 0;
	return XR_SUCCEEDED(m_functions.convertTime(m_instance, &t, &time)) ? time : 0;
}
}  // namespace devicebridge
