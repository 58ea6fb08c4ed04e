// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Drivers/Plugin/PluginLink.h"

#include <algorithm>
#include <utility>

#include "DeviceBridge/Drivers/AssumedLimits.h"

namespace devicebridge
{
static_assert(static_cast<int>(kHandJoints) == DEVICEBRIDGE_HAND_JOINTS);
static_assert(static_cast<int>(kHandJointsSensed) == DEVICEBRIDGE_HAND && static_cast<int>(kRotation) == DEVICEBRIDGE_ROTATION);
static_assert(static_cast<int>(kAssumedPeakForce) == DEVICEBRIDGE_ASSUMED_PEAK_FORCE);
static_assert(static_cast<int>(kAssumedMaxDamping) == DEVICEBRIDGE_ASSUMED_MAX_DAMPING);
static_assert(static_cast<int>(kAssumedWorkspaceRadius) == DEVICEBRIDGE_ASSUMED_WORKSPACE_RADIUS);
static_assert(static_cast<int>(kReady) == (DEVICEBRIDGE_CALIBRATED | DEVICEBRIDGE_FORCES_ENABLED | DEVICEBRIDGE_HAND_PRESENT));

namespace
{
template <std::size_t N> std::string text(const char (&field)[N]) { return {field, std::find(field, field + N, '\0')}; }

ist::Vec3 vec(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

DeviceInfo infoOf(const devicebridge_info& from, const std::string& uri)
{
	DeviceInfo info;
	info.uri = uri;
	info.model = text(from.model), info.maker = text(from.maker), info.serial = text(from.serial), info.source = text(from.source);
	info.sensed = from.sensed, info.actuated = from.actuated;
	if (from.handedness == DEVICEBRIDGE_LEFT) info.handedness = Handedness::Left;
	if (from.handedness == DEVICEBRIDGE_RIGHT) info.handedness = Handedness::Right;
	info.peakForce = from.peak_force, info.continuousForce = from.continuous_force;
	info.peakTorque = from.peak_torque, info.continuousTorque = from.continuous_torque;
	info.maxStiffness = from.max_stiffness, info.maxAngularStiffness = from.max_angular_stiffness;
	info.maxDamping = from.max_damping, info.maxAngularDamping = from.max_angular_damping;
	info.resolution = from.resolution, info.angularResolution = from.angular_resolution;
	info.workspaceRadius = from.workspace_radius;
	if (from.nominal_rate > 0) info.nominalRate = from.nominal_rate;
	info.damping = from.damping, info.angularDamping = from.angular_damping;
	info.assumed = from.assumed, info.profile = text(from.profile);
	assumeLimits(info);
	return info;
}

void copyState(const devicebridge_state& from, DeviceState& to)
{
	to.flags = from.flags;
	to.buttons = from.buttons;
	to.velocityEstimated = from.velocity_estimated != 0;
	to.X_WH.translation = vec(from.position);
	for (int i = 0; i < 9; ++i) to.X_WH.rotation.m[i / 3][i % 3] = from.rotation[i];
	to.twist = {vec(from.linear), vec(from.angular)};
	to.gripAngle = from.grip_angle;
	to.gripVelocity = from.grip_velocity;
}

void copyHand(const devicebridge_state& from, HandState& to)
{
	to.left = from.hand_is_left != 0;
	for (std::size_t i = 0; i < to.joints.size(); ++i)
	{
		const devicebridge_joint& j = from.joints[i];
		to.joints[i] = {
			vec(j.position), {j.orientation[0], j.orientation[1], j.orientation[2], j.orientation[3]}, j.radius, j.tracked != 0};
	}
}

void resetState(devicebridge_state& state)
{
	state = {};
	state.size = sizeof state;
	state.flags = kReady;
	state.rotation[0] = state.rotation[4] = state.rotation[8] = 1;
}
}  // namespace

PluginLink::PluginLink(const devicebridge_plugin& plugin, std::string address, std::string uri)
	: m_plugin(plugin),
	  m_address(std::move(address)),
	  m_uri(std::move(uri))
{}

std::string PluginLink::complaint() const
{
	const std::string why = text(reinterpret_cast<const char(&)[512]>(*m_why.data()));
	return why.empty() ? "the plug-in " + std::string(m_plugin.name) + " has lost its device and does not say why" : why;
}

ist::Result<DeviceInfo> PluginLink::connect() noexcept
{
	devicebridge_info info{};
	info.size = sizeof info;
	m_why.fill('\0');
	resetState(m_state);
	m_device = m_plugin.open(m_address.c_str(), &info, m_why.data(), m_why.size());
	if (!m_device && m_why[0] == '\0')
		return ist::Error{"the plug-in " + std::string(m_plugin.name) + " opens no device and does not say why", false};
	if (!m_device) return ist::Error{complaint(), false};
	m_hasHand = (info.sensed & DEVICEBRIDGE_HAND) != 0;
	return infoOf(info, m_uri);
}

DeviceLink::Event PluginLink::exchange(const DeviceCommand& command, DeviceSample& sample) noexcept
{
	const ist::Vec3 &f = command.wrench.force, &t = command.wrench.torque;
	const devicebridge_command wanted{sizeof wanted, 0, {f.x, f.y, f.z}, {t.x, t.y, t.z}, command.gripForce};
	m_state.size = sizeof m_state;
	m_state.flags = kReady;
	const int news = m_plugin.exchange(m_device, &wanted, &m_state, m_why.data(), m_why.size());
	if (news < 0) return Event::Lost;
	if (news == 0) return Event::Nothing;
	copyState(m_state, sample.state);
	if (m_hasHand) copyHand(m_state, sample.hand);
	return Event::Sample;
}

void PluginLink::disconnect() noexcept
{
	if (m_device) m_plugin.close(m_device);
	m_device = nullptr;
}
}  // namespace devicebridge
