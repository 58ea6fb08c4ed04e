// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/OpenXr/OpenXrLink.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "DeviceBridge/Drivers/OpenXr/OpenXrSession.h"
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge
{
static_assert(static_cast<int>(kHandJoints) == XR_HAND_JOINT_COUNT_EXT && static_cast<int>(kPalm) == XR_HAND_JOINT_PALM_EXT);
static_assert(static_cast<int>(kThumbTip) == XR_HAND_JOINT_THUMB_TIP_EXT && static_cast<int>(kIndexTip) == XR_HAND_JOINT_INDEX_TIP_EXT);
static_assert(static_cast<int>(kLittleTip) == XR_HAND_JOINT_LITTLE_TIP_EXT &&
	static_cast<int>(kMiddleMetacarpal) == XR_HAND_JOINT_MIDDLE_METACARPAL_EXT);

namespace
{
constexpr std::int64_t kPeriod = 4'000'000;  // period of the queries, shorter than that of any runtime [ns]
constexpr XrSpaceLocationFlags kPoseValid = XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;

ist::Vec3 vec(const XrVector3f& v) { return {v.x, v.y, v.z}; }

ist::Quaternion unit(const XrQuaternionf& q)
{
	const ist::Quaternion d{q.x, q.y, q.z, q.w};
	const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z + d.w * d.w);
	return length > 0.5 ? ist::Quaternion{d.x / length, d.y / length, d.z / length, d.w / length} : ist::Quaternion{};
}
}  // namespace

struct OpenXrLink::Tracker
{
	const OpenXrSession::Functions& functions;
	XrHandTrackerEXT handle = XR_NULL_HANDLE;
	XrHandJointLocationEXT joints[XR_HAND_JOINT_COUNT_EXT] = {};
	XrHandJointVelocityEXT velocities[XR_HAND_JOINT_COUNT_EXT] = {};
	bool active = false;

	explicit Tracker(const OpenXrSession& session) : functions(session.functions()) {}
	~Tracker()
	{
		if (handle != XR_NULL_HANDLE) functions.destroyHandTracker(handle);
	}
	XrResult create(const OpenXrSession& session, bool left)
	{
		XrHandTrackerCreateInfoEXT info{};
		info.type = XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT;
		info.hand = left ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT;
		info.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
		return functions.createHandTracker(session.session(), &info, &handle);
	}
	XrResult locate(const OpenXrSession& session)
	{
		XrHandJointVelocitiesEXT moving{};
		moving.type = XR_TYPE_HAND_JOINT_VELOCITIES_EXT;
		moving.jointCount = XR_HAND_JOINT_COUNT_EXT;
		moving.jointVelocities = velocities;
		XrHandJointLocationsEXT located{};
		located.type = XR_TYPE_HAND_JOINT_LOCATIONS_EXT;
		located.next = &moving;
		located.jointCount = XR_HAND_JOINT_COUNT_EXT;
		located.jointLocations = joints;
		XrHandJointsLocateInfoEXT info{};
		info.type = XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT;
		info.baseSpace = session.space();
		info.time = session.now();
		const XrResult result = functions.locateHandJoints(handle, &info, &located);
		active = XR_SUCCEEDED(result) && located.isActive;
		return result;
	}
	bool tracked(int joint) const { return active && (joints[joint].locationFlags & kPoseValid) == kPoseValid; }
};

OpenXrLink::OpenXrLink(bool left, std::string uri) : m_left(left), m_uri(std::move(uri)) {}

OpenXrLink::~OpenXrLink() { disconnect(); }

ist::Result<DeviceInfo> OpenXrLink::connect() noexcept
{
	auto session = OpenXrSession::shared();
	if (!session) return session.error();
	m_session = std::move(session).value();
	m_tracker = std::make_unique<Tracker>(*m_session);
	const XrResult result = m_tracker->create(*m_session, m_left);
	if (XR_FAILED(result)) return ist::Error{"the OpenXR runtime tracks no such hand (" + openXrError(XR_NULL_HANDLE, result) + ")", false};
	m_lastPalm = {};
	DeviceInfo info;
	info.uri = m_uri;
	info.model = m_left ? "left hand" : "right hand";
	info.handedness = m_left ? Handedness::Left : Handedness::Right;
	info.maker = m_session->runtimeName();
	info.sensed = kTranslation | kRotation | kHandJointsSensed;
	info.nominalRate = 1e9 / kPeriod;
	return info;
}

DeviceLink::Event OpenXrLink::lost(const std::string& why)
{
	m_complaint = why;
	return Event::Lost;
}

DeviceLink::Event OpenXrLink::exchange(const DeviceCommand&, DeviceSample& sample) noexcept
{
	RealClock clock;
	m_next = std::max(m_next + kPeriod, clock.now());
	clock.sleepUntil(m_next);
	const std::string ended = m_session->poll();
	if (!ended.empty()) return lost(ended);
	const XrResult result = m_tracker->locate(*m_session);
	if (XR_FAILED(result)) return lost("the OpenXR runtime does not answer any more (" + openXrError(XR_NULL_HANDLE, result) + ")");
	const Tracker& t = *m_tracker;
	sample.hand.left = m_left;
	for (int i = 0; i < kHandJoints; ++i)
	{
		const XrHandJointLocationEXT& j = t.joints[i];
		if (t.tracked(i))
			sample.hand.joints[static_cast<std::size_t>(i)] = {vec(j.pose.position), unit(j.pose.orientation), j.radius, true};
	}
	if (t.tracked(kPalm)) m_lastPalm = {rotationMatrix(unit(t.joints[kPalm].pose.orientation)), vec(t.joints[kPalm].pose.position)};
	else sample.state.flags &= ~static_cast<std::uint32_t>(kHandPresent);
	const XrHandJointVelocityEXT& v = t.velocities[kPalm];
	if (t.tracked(kPalm) && (v.velocityFlags & XR_SPACE_VELOCITY_LINEAR_VALID_BIT)) sample.state.twist.linear = vec(v.linearVelocity);
	if (t.tracked(kPalm) && (v.velocityFlags & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT)) sample.state.twist.angular = vec(v.angularVelocity);
	sample.state.velocityEstimated = true;
	sample.state.X_WH = m_lastPalm;
	return Event::Sample;
}

void OpenXrLink::disconnect() noexcept
{
	m_tracker.reset();
	m_session.reset();
}

std::string openXrMissing()
{
	const auto session = OpenXrSession::shared();
	return session ? std::string() : session.error().message;
}
}  // namespace devicebridge
