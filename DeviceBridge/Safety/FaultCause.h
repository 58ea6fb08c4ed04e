// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>

namespace devicebridge
{
/// Why a device is held at zero.
enum class FaultCause
{
	None,
	NotFinite,      ///< wrench or grip force
	InvalidState,   ///< pose or twist not finite, or pose not rigid
	Disconnected,   ///< read or write failed
	Frozen,         ///< samples repeat
	Jump,           ///< the handle is further away, or turned further, than a hand can have moved it
	Stalled,        ///< a tick took so long that the last command expired
	ClockJump,      ///< the clock ran backwards
	HookException,  ///< a listener or the force law threw
	Raised,         ///< by the program itself
	ToolNotFinite   ///< the velocity that a step left the tool with
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
	case FaultCause::ToolNotFinite: return "a step left the tool with a velocity that is not finite";
	}
	return "unknown fault";
}

struct Fault
{
	FaultCause cause = FaultCause::None;
	std::int64_t at = 0;   ///< [ns]
	bool latched = false;  ///< zero until clearFault(); otherwise the force comes back by itself, along the ramp
};
}  // namespace devicebridge
