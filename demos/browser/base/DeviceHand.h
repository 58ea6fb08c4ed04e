// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Device/Device.h"
#include "demos/browser/base/BrowsableDemo.h"

#include <memory>

namespace browser
{
/// A device of DeviceBridge that moves what the browser's hand holds, at the rate of the pictures: way for way, turn for turn. It gets no
/// force from here; forces at a hand want a stepping thread (haptic-bunny, scene files).
class DeviceHand
{
public:
	/// Errors: no driver, no such device, or one that does not open.
	static ist::Result<std::unique_ptr<DeviceHand>> open(const std::string& address);
	explicit DeviceHand(std::unique_ptr<devicebridge::Device> device) : m_device(std::move(device)) {}

	/// Moves the demo's tool by what the hand moved since the last call; `scale`: metres of the scene for one of the hand's. A device that
	/// does not answer moves nothing, and goes on without a leap when it is back.
	void update(BrowsableDemo& demo, double scale);
	/// Why the device does not answer, in a sentence; empty while it does.
	const std::string& trouble() const { return m_trouble; }
	/// The next call begins anew, without a move.
	void forget() { m_known = false; }
	double workspaceRadius() const { return m_device->info().workspaceRadius; }

private:
	std::unique_ptr<devicebridge::Device> m_device;
	ist::Pose m_last;
	bool m_known = false;
	std::string m_trouble;
};
}  // namespace browser
