// SPDX-License-Identifier: Zlib
#pragma once

#include "DeviceBridge/Decorators/DeviceDecorator.h"

namespace devicebridge
{
/// First-order low-pass of the twist, exact for samples at any spacing. With `fromPositions` the twist is the difference of the reported
/// poses instead of the device's own twist. The delay is 1 / (2 pi cutoff).
class VelocityFilter final : public DeviceDecorator
{
public:
	/// `cutoff` [Hz]; not positive: no low-pass.
	VelocityFilter(std::unique_ptr<Device> inner, double cutoff, bool fromPositions = false)
		: DeviceDecorator(std::move(inner)),
		  m_cutoff(cutoff),
		  m_fromPositions(fromPositions)
	{}

	DeviceStatus open() noexcept override;
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override;

private:
	ist::Twist rawTwist(const DeviceState& state, double dt) const noexcept;

	double m_cutoff;
	bool m_fromPositions;
	bool m_hasLast = false;
	DeviceState m_last;
	ist::Twist m_filtered;
};
}  // namespace devicebridge
