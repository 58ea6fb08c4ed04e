// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

#include "DeviceBridge/Loop/ContactSource.h"

namespace devicebridge
{
/// The law that gives the wrench on the hand.
class ForceLaw
{
public:
	virtual ~ForceLaw() = default;
	/// Wrench on the hand, about the origin of H, in W.
	virtual ist::Wrench handWrench(const DeviceState& hand, const ToolStep& step) noexcept = 0;
	/// Time at which the wrench was computed [ns]. A law that passes on the result of a slower thread returns the time of that result, so
	/// that the wrench fades as it ages.
	virtual std::int64_t computedAt(const DeviceState& hand) const noexcept { return hand.sampledAt; }
};

/// The reaction of the virtual coupling. Its torque is about the origin of the tool, which the coupling pulls to the origin of the hand.
class CouplingForceLaw final : public ForceLaw
{
public:
	ist::Wrench handWrench(const DeviceState&, const ToolStep& step) noexcept override { return -1.0 * step.coupling; }
};
}  // namespace devicebridge
