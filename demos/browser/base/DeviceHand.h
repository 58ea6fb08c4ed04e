// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Device.h"
#include "demos/browser/base/BrowsableDemo.h"

#include <memory>

namespace browser
{
/// A device of DeviceBridge that moves the body that the browser's hand holds, once a picture. Translations and rotations are copied. The
/// device receives no force: for that a ForceHand has a thread of its own.
class DeviceHand
{
public:
	/// Opens a device. Errors: there is no driver or no such device, or it does not open.
	static ist::Result<std::unique_ptr<DeviceHand>> open(const std::string& address);
	explicit DeviceHand(std::unique_ptr<devicebridge::Device> device) : m_device(std::move(device)) {}

	/// Moves the demo's tool by the hand's motion since the last call. `scale` is in metres of the scene per metre of the hand. A device
	/// that does not answer moves nothing, and continues without a jump when it answers again.
	void update(BrowsableDemo& demo, double scale);
	/// Reason why the device does not answer, in a sentence; empty while it answers.
	const std::string& trouble() const { return m_trouble; }
	/// State of the device in words: trouble(), or what of it is not ready and how to change that, or that it moves no tool, or "ready".
	std::string state() const;
	/// Makes the next call start again, without a motion.
	void forget() { m_known = false; }
	devicebridge::Device& device() { return *m_device; }
	double workspaceRadius() const { return m_device->info().workspaceRadius; }

private:
	std::unique_ptr<devicebridge::Device> m_device;
	ist::Pose m_last;
	bool m_known = false;
	unsigned m_flags = devicebridge::kReady;  // of the last sample
	std::string m_trouble;
};
}  // namespace browser
