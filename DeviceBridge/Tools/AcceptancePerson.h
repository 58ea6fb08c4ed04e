// SPDX-License-Identifier: Zlib
#pragma once

#include <optional>
#include <string>

#include "BulletISTCollision/Core/Base/Result.h"
#include "DeviceBridge/Device/Device.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Timing/Clock.h"

namespace devicebridge::tools
{
/// The person at a device, who reads what to do on standard error and answers on standard input. On a simulated device a simulated hand
/// does it, and only the answers are read.
class AcceptancePerson
{
public:
	AcceptancePerson(Device& device, Clock& clock);

	bool isSimulated() const { return m_simulated != nullptr; }
	void tell(const std::string& text) const;
	/// The answer, without spaces around it; empty for Enter alone. Null when standard input has ended.
	std::optional<std::string> ask(const std::string& question);

	/// The simulated hand moves from where it is, by a displacement [m] and a rotation vector about its place [rad], in the axes of
	/// W, within `seconds` after a `wait` [s], and then holds still. A real one does nothing.
	void move(const ist::Vec3& by, const ist::Vec3& turn = {}, double seconds = 1, double wait = 0);
	/// Pulls the plug of a simulated device, or puts it in again.
	void unplug();
	void plugIn();

	/// Reads for a tenth of a second, and on a simulated device for two seconds before. Position is the mean; everything else is that of
	/// the last sample.
	ist::Result<DeviceState> sample();

private:
	Device& m_device;
	Clock& m_clock;
	SimulatedDevice* m_simulated = nullptr;
	ist::Pose m_hand;
};
}  // namespace devicebridge::tools
