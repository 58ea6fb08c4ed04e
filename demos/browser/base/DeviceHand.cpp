// SPDX-License-Identifier: Zlib
#include "demos/browser/base/DeviceHand.h"

#include "DeviceBridge/Device/DeviceAddress.h"
#include "DeviceBridge/Drivers/DeviceRegistry.h"

#include <chrono>

using namespace ist;

namespace browser
{
Result<std::unique_ptr<DeviceHand>> DeviceHand::open(const std::string& address)
{
	auto device = devicebridge::DeviceRegistry().open(address);
	if (!device) return device.error();
	return std::make_unique<DeviceHand>(std::move(device).value());
}

void DeviceHand::update(BrowsableDemo& demo, double scale)
{
	const std::int64_t now =
		std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
	devicebridge::DeviceState state;
	const devicebridge::DeviceStatus status = m_device->read(now, state);
	if (status != devicebridge::DeviceStatus::Ok || !isRigid(state.X_WH))
	{
		m_known = false;
		if (!m_trouble.empty()) return;
		const std::string complaint = m_device->complaint();
		m_trouble = "the device is lost: " + (complaint.empty() ? std::string(devicebridge::describe(status)) : complaint);
		return;
	}
	m_trouble.clear();
	m_flags = state.flags;
	const Pose X = state.X_WH;
	// This works as a clutch: the hand may move freely while no body is held.
	if (m_known && demo.grabTool())
		demo.drag(scale * (X.translation - m_last.translation), rotationVector(quaternion(X.rotation * transpose(m_last.rotation))));
	m_last = X;
	m_known = true;
}

std::string DeviceHand::state() const
{
	if (!m_trouble.empty()) return m_trouble;
	const std::string missing = devicebridge::describeMissing(m_flags);
	const unsigned sensed = m_device->info().sensed, pose = devicebridge::kTranslation | devicebridge::kRotation;
	if (missing.empty() && (sensed & devicebridge::kHandJointsSensed) && !(sensed & pose))
		return "senses joints of a hand alone, and moves no tool; a hand with parts in a scene file follows it";
	if (missing.empty()) return "ready";
	if (m_flags & devicebridge::kCalibrated) return missing;
	return missing + ": " + devicebridge::howToCalibrate(m_device->info().uri);
}
}  // namespace browser
