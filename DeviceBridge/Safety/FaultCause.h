// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace devicebridge
{
/// Why the device's force is held at zero.
enum class FaultCause
{
	None,
	NotFinite,      ///< wrench or grip force that is not finite
	InvalidState,   ///< pose or twist that is not finite, or pose that is not rigid
	Disconnected,   ///< read or write that failed
	Frozen,         ///< samples that repeat
	Jump,           ///< position or orientation that is farther away than a hand can have moved the handle
	Stalled,        ///< tick that took so long that the last command expired
	ClockJump,      ///< clock that ran backwards
	HookException,  ///< exception of a listener or of the force law
	Raised,         ///< fault raised by the program itself
	ToolNotFinite,  ///< tool velocity after a step that is not finite
	PositionFrozen  ///< position that stays the same to the last bit while the handle turns
};

inline const char* describe(FaultCause cause) noexcept
{
	switch (cause)
	{
	case FaultCause::None: return "no fault";
	case FaultCause::NotFinite: return "the wrench was not finite";
	case FaultCause::InvalidState: return "the device reported a pose or twist that is not finite or not rigid";
	case FaultCause::Disconnected: return "the device does not answer";
	case FaultCause::Frozen: return "the device repeats its samples";
	case FaultCause::Jump: return "the handle jumped";
	case FaultCause::Stalled: return "a tick took longer than a command lives";
	case FaultCause::ClockJump: return "the clock ran backwards";
	case FaultCause::HookException: return "a hook threw an exception";
	case FaultCause::Raised: return "the program raised a fault";
	case FaultCause::PositionFrozen: return "the position stands still while the handle turns: calibrate the device";
	case FaultCause::ToolNotFinite: return "a step left the tool with a velocity that is not finite";
	}
	return "unknown fault";
}

struct Fault
{
	FaultCause cause = FaultCause::None;
	std::int64_t at = 0;   ///< [ns]
	bool latched = false;  ///< whether zero holds until clearFault(); otherwise the force returns by itself, along the ramp
};
}  // namespace devicebridge
