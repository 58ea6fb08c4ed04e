// SPDX-License-Identifier: Zlib
#pragma once

#include <cstdint>
#include <string>

#include "BulletISTCollision/Core/Base/Pose.h"
#include "DeviceBridge/Device/HandState.h"

namespace devicebridge
{
/// Bits of DeviceInfo::sensed and DeviceInfo::actuated.
enum DegreeOfFreedom : unsigned
{
	kTranslation = 0x07,
	kRotation = 0x38,
	kGrip = 0x40,
	kHandJointsSensed = 0x80  ///< readHand() answers
};

/// For which hand a device is made.
enum class Handedness
{
	Either,  ///< or unknown
	Left,
	Right
};

/// Bits of DeviceInfo::assumed.
enum AssumedLimit : unsigned
{
	kAssumedPeakForce = 0x01,
	kAssumedContinuousForce = 0x02,
	kAssumedPeakTorque = 0x04,
	kAssumedContinuousTorque = 0x08,
	kAssumedMaxStiffness = 0x10,
	kAssumedMaxAngularStiffness = 0x20,
	kAssumedMaxDamping = 0x40,
	kAssumedMaxAngularDamping = 0x80,
	kAssumedDamping = 0x100,
	kAssumedAngularDamping = 0x200,
	kAssumedWorkspaceRadius = 0x400
};

/// What a device is and what it can bear. A peak of zero is unknown, and nothing is sent through it; a continuous limit of
/// zero is unknown, and a quarter of the peak is assumed. Any other zero is unknown, too.
struct DeviceInfo
{
	std::string model, maker, serial, uri;
	unsigned sensed = 0, actuated = 0;
	Handedness handedness = Handedness::Either;
	double peakForce = 0, continuousForce = 0;         ///< [N]
	double peakTorque = 0, continuousTorque = 0;       ///< [N m]
	double maxStiffness = 0, maxAngularStiffness = 0;  ///< at 1 kHz [N/m, N m/rad]
	double maxDamping = 0, maxAngularDamping = 0;      ///< at 1 kHz [N s/m, N m s/rad]
	double damping = 0, angularDamping = 0;            ///< of the mechanism itself, for passiveGains() [N s/m, N m s/rad]
	double resolution = 0, angularResolution = 0;      ///< [m, rad]
	double workspaceRadius = 0;                        ///< of the inscribed ball [m]
	double nominalRate = 1000;                         ///< [Hz]
	std::string source;                                ///< where each of the values above comes from
	unsigned assumed = 0;  ///< bits of AssumedLimit: limits that the device itself does not tell. They are those of its model, or a guess
	std::string profile;   ///< of data/devices, from which limits were assumed; empty: none
};

enum class DeviceStatus
{
	Ok,
	NotOpen,
	Disconnected,
	NotCalibrated,
	InvalidState,
	Refused
};

inline const char* describe(DeviceStatus status) noexcept
{
	switch (status)
	{
	case DeviceStatus::Ok: return "ok";
	case DeviceStatus::NotOpen: return "the device is not open";
	case DeviceStatus::Disconnected: return "the device does not answer";
	case DeviceStatus::NotCalibrated: return "the device is not calibrated";
	case DeviceStatus::InvalidState: return "the device reported a pose or twist that is not finite or not rigid";
	case DeviceStatus::Refused: return "the device refused the command";
	}
	return "unknown status";
}

/// Bits of DeviceState::flags.
enum DeviceFlag : unsigned
{
	kCalibrated = 1,
	kForcesEnabled = 2,  ///< the device's own switch
	kHandPresent = 4,    ///< dead-man's switch; set where the device has none
	kReady = kCalibrated | kForcesEnabled | kHandPresent
};

/// One sample of the hand. W is the device's world frame, H the frame of the handle.
struct DeviceState
{
	std::uint64_t sequence = 0;  ///< grows with each new sample; always zero where the driver does not number them
	std::int64_t sampledAt = 0;  ///< [ns], on the clock whose time was given to read()
	ist::Pose X_WH;
	ist::Twist twist;  ///< of the origin of H, in W
	std::uint32_t buttons = 0;
	std::uint32_t flags = kReady;            ///< force only while all bits of kReady are set
	double gripAngle = 0, gripVelocity = 0;  ///< [rad, rad/s]
	bool velocityEstimated = false;          ///< from positions rather than measured
};

/// What the device shall exert on the hand.
struct DeviceCommand
{
	std::uint64_t sequence = 0;
	std::uint64_t basedOn = 0;    ///< DeviceState::sequence that it answers
	std::int64_t computedAt = 0;  ///< [ns]
	std::int64_t expiresAt = 0;   ///< [ns]; from then on it counts as zero
	ist::Wrench wrench;           ///< on the hand, about the origin of H, in W
	double gripForce = 0;         ///< [N]
};

/// A haptic device. After open() no call allocates, blocks for longer than one period, or throws.
class Device
{
public:
	virtual ~Device() = default;

	virtual const DeviceInfo& info() const noexcept = 0;
	virtual DeviceStatus open() noexcept = 0;
	/// Leaves the device without force.
	virtual void close() noexcept = 0;
	/// `now` [ns] never decreases from call to call. `state` is unchanged unless the answer is Ok.
	virtual DeviceStatus read(std::int64_t now, DeviceState& state) noexcept = 0;
	/// Held until the next one, at the longest until it expires: then the driver itself lets go, also while nobody calls.
	virtual DeviceStatus write(const DeviceCommand& command) noexcept = 0;
	/// The joints of the sample that the last read() gave. False, and `hand` unchanged, where the device senses none.
	virtual bool readHand(HandState&) noexcept { return false; }
	/// In a sentence, why open() failed or the device was lost; empty when nothing is to be said. Not on the tick: it allocates and
	/// may wait.
	virtual std::string complaint() const { return {}; }
};
}  // namespace devicebridge
