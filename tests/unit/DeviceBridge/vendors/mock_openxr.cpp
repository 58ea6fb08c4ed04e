// SPDX-License-Identifier: Zlib
// A mock OpenXR runtime without a headset, found by the real loader through XR_RUNTIME_JSON. It has only the functions that the driver
// calls. Negotiation: Khronos, openxr_loader_negotiation.h of OpenXR-SDK-Source.
#define XR_USE_TIMESPEC
#include <time.h>

#include <algorithm>
#include <cstring>
#include <deque>

#include "tests/unit/DeviceBridge/vendors/MockOpenXr.h"

#include <openxr/openxr_platform.h>

namespace
{
struct LoaderInfo
{
	int structType;
	std::uint32_t structVersion;
	std::size_t structSize;
	std::uint32_t minInterfaceVersion, maxInterfaceVersion;
	XrVersion minApiVersion, maxApiVersion;
};
struct RuntimeRequest
{
	int structType;
	std::uint32_t structVersion;
	std::size_t structSize;
	std::uint32_t runtimeInterfaceVersion;
	XrVersion runtimeApiVersion;
	PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};

MockOpenXr mock;
using Lock = std::lock_guard<std::mutex>;
std::deque<XrSessionState> events;
constexpr std::uint64_t kInstance = 11, kSession = 22, kSpace = 33, kLeft = 44;
template <class Handle> Handle handle(std::uint64_t value) { return reinterpret_cast<Handle>(value); }

XrResult XRAPI_CALL enumerateExtensions(const char*, std::uint32_t room, std::uint32_t* count, XrExtensionProperties* properties)
{
	const char* const names[] = {
		XR_EXT_HAND_TRACKING_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, XR_MND_HEADLESS_EXTENSION_NAME};
	const Lock lock(mock.mutex);
	*count = mock.hasHeadless ? 3 : 2;
	for (std::uint32_t i = 0; i < std::min(room, *count); ++i) std::strcpy(properties[i].extensionName, names[i]);
	return room == 0 || room >= *count ? XR_SUCCESS : XR_ERROR_SIZE_INSUFFICIENT;
}
XrResult XRAPI_CALL createInstance(const XrInstanceCreateInfo* info, XrInstance* instance)
{
	const Lock lock(mock.mutex);
	if (mock.gone) return XR_ERROR_RUNTIME_UNAVAILABLE;
	if (info->type != XR_TYPE_INSTANCE_CREATE_INFO || info->enabledExtensionCount != 3) ++mock.misuse;
	if (++mock.instances > 1) return XR_ERROR_LIMIT_REACHED;
	*instance = handle<XrInstance>(kInstance);
	return XR_SUCCESS;
}
XrResult XRAPI_CALL destroyInstance(XrInstance)
{
	const Lock lock(mock.mutex);
	if (mock.sessions || mock.trackers) ++mock.misuse;
	--mock.instances;
	return XR_SUCCESS;
}
XrResult XRAPI_CALL getInstanceProperties(XrInstance, XrInstanceProperties* properties)
{
	std::strcpy(properties->runtimeName, "mock runtime");
	return XR_SUCCESS;
}
XrResult XRAPI_CALL resultToString(XrInstance, XrResult result, char text[XR_MAX_RESULT_STRING_SIZE])
{
	std::strcpy(text, result == XR_ERROR_FORM_FACTOR_UNAVAILABLE ? "XR_ERROR_FORM_FACTOR_UNAVAILABLE" : "XR_ERROR_OTHER");
	return XR_SUCCESS;
}
XrResult XRAPI_CALL getSystem(XrInstance, const XrSystemGetInfo*, XrSystemId* system)
{
	const Lock lock(mock.mutex);
	*system = 1;
	return mock.hasHeadset ? XR_SUCCESS : XR_ERROR_FORM_FACTOR_UNAVAILABLE;
}
XrResult XRAPI_CALL getSystemProperties(XrInstance, XrSystemId, XrSystemProperties* properties)
{
	const Lock lock(mock.mutex);
	auto* const tracking = static_cast<XrSystemHandTrackingPropertiesEXT*>(properties->next);
	if (tracking && tracking->type == XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT) tracking->supportsHandTracking = mock.tracksHands;
	return XR_SUCCESS;
}
XrResult XRAPI_CALL createSession(XrInstance, const XrSessionCreateInfo* info, XrSession* session)
{
	const Lock lock(mock.mutex);
	if (info->systemId != 1 || info->next) ++mock.misuse;
	if (++mock.sessions > 1) return XR_ERROR_LIMIT_REACHED;
	events = {XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY};
	*session = handle<XrSession>(kSession);
	return XR_SUCCESS;
}
XrResult XRAPI_CALL destroySession(XrSession)
{
	const Lock lock(mock.mutex);
	--mock.sessions;
	return XR_SUCCESS;
}
XrResult XRAPI_CALL beginSession(XrSession, const XrSessionBeginInfo* info)
{
	const Lock lock(mock.mutex);
	if (info->primaryViewConfigurationType != XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO) ++mock.misuse;
	++mock.begun;
	return XR_SUCCESS;
}
XrResult XRAPI_CALL endSession(XrSession)
{
	const Lock lock(mock.mutex);
	--mock.begun;
	return XR_SUCCESS;
}
XrResult XRAPI_CALL createSpace(XrSession, const XrReferenceSpaceCreateInfo* info, XrSpace* space)
{
	const Lock lock(mock.mutex);
	if (info->referenceSpaceType != XR_REFERENCE_SPACE_TYPE_LOCAL || info->poseInReferenceSpace.orientation.w != 1) ++mock.misuse;
	*space = handle<XrSpace>(kSpace);
	return XR_SUCCESS;
}
XrResult XRAPI_CALL destroySpace(XrSpace) { return XR_SUCCESS; }
XrResult XRAPI_CALL pollEvent(XrInstance, XrEventDataBuffer* event)
{
	const Lock lock(mock.mutex);
	if (mock.gone) return XR_ERROR_INSTANCE_LOST;
	if (mock.exiting) events.push_back(XR_SESSION_STATE_EXITING);
	if (events.empty()) return XR_EVENT_UNAVAILABLE;
	auto& changed = reinterpret_cast<XrEventDataSessionStateChanged&>(*event);
	changed.type = XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED;
	changed.session = handle<XrSession>(kSession);
	changed.state = events.front();
	events.pop_front();
	return XR_SUCCESS;
}
XrResult XRAPI_CALL convertTime(XrInstance, const timespec* t, XrTime* time)
{
	*time = std::int64_t{t->tv_sec} * 1'000'000'000 + t->tv_nsec;
	return XR_SUCCESS;
}
XrResult XRAPI_CALL createTracker(XrSession, const XrHandTrackerCreateInfoEXT* info, XrHandTrackerEXT* tracker)
{
	const Lock lock(mock.mutex);
	if (info->handJointSet != XR_HAND_JOINT_SET_DEFAULT_EXT) ++mock.misuse;
	++mock.trackers;
	*tracker = handle<XrHandTrackerEXT>(kLeft + (info->hand == XR_HAND_RIGHT_EXT));
	return XR_SUCCESS;
}
XrResult XRAPI_CALL destroyTracker(XrHandTrackerEXT)
{
	const Lock lock(mock.mutex);
	--mock.trackers;
	return XR_SUCCESS;
}
XrResult XRAPI_CALL locateJoints(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT* info, XrHandJointLocationsEXT* located)
{
	const Lock lock(mock.mutex);
	if (mock.gone) return XR_ERROR_INSTANCE_LOST;
	if (info->baseSpace != handle<XrSpace>(kSpace) || info->time <= 0 || located->jointCount != XR_HAND_JOINT_COUNT_EXT) ++mock.misuse;
	const std::size_t hand = reinterpret_cast<std::uint64_t>(tracker) - kLeft;
	located->isActive = mock.active[hand] && mock.begun > 0;
	std::copy_n(mock.joints[hand], XR_HAND_JOINT_COUNT_EXT, located->jointLocations);
	auto* const moving = static_cast<XrHandJointVelocitiesEXT*>(located->next);
	if (!moving || moving->type != XR_TYPE_HAND_JOINT_VELOCITIES_EXT) return XR_SUCCESS;
	moving->jointVelocities[XR_HAND_JOINT_PALM_EXT] = {
		XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT, mock.palmVelocity[hand], mock.palmTurning[hand]};
	return XR_SUCCESS;
}

XrResult XRAPI_CALL getProcAddress(XrInstance, const char* name, PFN_xrVoidFunction* function)
{
	struct Row
	{
		const char* name;
		PFN_xrVoidFunction function;
	};
#define ROW(name, f) \
	{ \
		name, reinterpret_cast<PFN_xrVoidFunction>(f) \
	}
	static const Row rows[] = {ROW("xrGetInstanceProcAddr", getProcAddress),
		ROW("xrEnumerateInstanceExtensionProperties", enumerateExtensions), ROW("xrCreateInstance", createInstance),
		ROW("xrDestroyInstance", destroyInstance), ROW("xrGetInstanceProperties", getInstanceProperties),
		ROW("xrResultToString", resultToString), ROW("xrGetSystem", getSystem), ROW("xrGetSystemProperties", getSystemProperties),
		ROW("xrCreateSession", createSession), ROW("xrDestroySession", destroySession), ROW("xrBeginSession", beginSession),
		ROW("xrEndSession", endSession), ROW("xrCreateReferenceSpace", createSpace), ROW("xrDestroySpace", destroySpace),
		ROW("xrPollEvent", pollEvent), ROW("xrConvertTimespecTimeToTimeKHR", convertTime), ROW("xrCreateHandTrackerEXT", createTracker),
		ROW("xrDestroyHandTrackerEXT", destroyTracker), ROW("xrLocateHandJointsEXT", locateJoints)};
#undef ROW
	*function = nullptr;
	for (const Row& row : rows)
		if (std::strcmp(row.name, name) == 0) *function = row.function;
	return *function ? XR_SUCCESS : XR_ERROR_FUNCTION_UNSUPPORTED;
}
}  // namespace

MockOpenXr* mockOpenXr() { return &mock; }

extern "C" __attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(
	const LoaderInfo* loader, RuntimeRequest* request)
{
	if (loader->structType != 1 || request->structType != 3 || request->structSize != sizeof(RuntimeRequest))
		return XR_ERROR_INITIALIZATION_FAILED;
	request->runtimeInterfaceVersion = 1;
	request->runtimeApiVersion = XR_CURRENT_API_VERSION;
	request->getInstanceProcAddr = getProcAddress;
	return XR_SUCCESS;
}
