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
	kHandJointsSensed = 0x80  ///< readHand() returns joints
};

/// The hand for which a device is made.
enum class Handedness
{
	Either,  ///< also the value if the maker does not say
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

/// Properties and limits of a device. Zero means unknown, for every number here. If a peak is unknown, nothing is sent to those motors. If
/// a continuous limit is unknown, a quarter of the peak is used instead.
struct DeviceInfo
{
	std::string model, maker, serial, uri;
	unsigned sensed = 0, actuated = 0;
	Handedness handedness = Handedness::Either;
	double peakForce = 0, continuousForce = 0;         ///< [N]
	double peakTorque = 0, continuousTorque = 0;       ///< [N m]
	double maxStiffness = 0, maxAngularStiffness = 0;  ///< largest stiffness at 1 kHz [N/m, N m/rad]
	double maxDamping = 0, maxAngularDamping = 0;      ///< largest damping at 1 kHz [N s/m, N m s/rad]
	double damping = 0, angularDamping = 0;            ///< the mechanism's own, for passiveGains() [N s/m, N m s/rad]
	double resolution = 0, angularResolution = 0;      ///< smallest steps of position and angle [m, rad]
	double workspaceRadius = 0;                        ///< radius of the inscribed ball [m]
	double nominalRate = 1000;                         ///< rate of the samples [Hz]
	/// Displacement in the world over that of the handle (MountedDevice). All limits and lengths above are those in the world.
	double scale = 1;
	/// Whether the position may repeat to the last bit while the handle turns. A held handle always trembles; simulated and replayed ones
	/// and mice need not.
	bool turnsInPlace = false;
	std::string source;    ///< origin of each value above, in words
	unsigned assumed = 0;  ///< bits of AssumedLimit: limits that come from the profile of the model, or are guesses
	std::string profile;   ///< name of the profile in data/devices from which limits were assumed; empty: none
};

/// Changes the limits of a device for a world in which one metre of its handle is `scale` metres. Power is preserved, so forces shrink by
/// the scale, and linear stiffness and damping by its square. Rotation does not change.
inline void scaleLimits(DeviceInfo& info, double scale) noexcept
{
	for (double* length : {&info.resolution, &info.workspaceRadius, &info.scale}) *length *= scale;
	for (double* force : {&info.peakForce, &info.continuousForce}) *force /= scale;
	for (double* gain : {&info.maxStiffness, &info.maxDamping, &info.damping}) *gain /= scale * scale;
}

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
	kForcesEnabled = 2,  ///< state of the device's own switch
	kHandPresent = 4,    ///< state of the dead-man's switch; always set if the device has none
	kReady = kCalibrated | kForcesEnabled | kHandPresent
};

/// The bits of kReady that are missing, in words: "not calibrated, no hand on it". Empty if none is.
inline std::string describeMissing(unsigned flags)
{
	std::string all;
	const auto add = [&](DeviceFlag flag, const char* what) {
		if (!(flags & flag)) all += (all.empty() ? "" : ", ") + std::string(what);
	};
	add(kCalibrated, "not calibrated");
	add(kForcesEnabled, "forces off at its switch");
	add(kHandPresent, "no hand on it");
	return all;
}

/// One sample of the hand. W is the device's world frame, H the frame of the handle.
struct DeviceState
{
	std::uint64_t sequence = 0;  ///< number that grows with each new sample; always zero if the driver does not number them
	std::int64_t sampledAt = 0;  ///< time of the sample on the clock of read() [ns]
	ist::Pose X_WH;
	ist::Twist twist;  ///< velocity of the origin of H, in W
	std::uint32_t buttons = 0;
	std::uint32_t flags = kReady;            ///< bits of DeviceFlag; force is sent only while all bits of kReady are set
	double gripAngle = 0, gripVelocity = 0;  ///< [rad, rad/s]
	bool velocityEstimated = false;          ///< whether the twist was computed from positions instead of measured
};

/// Wrench and grip force that the device is to exert on the hand.
struct DeviceCommand
{
	std::uint64_t sequence = 0;
	std::uint64_t basedOn = 0;    ///< DeviceState::sequence of the sample from which it was computed
	std::int64_t computedAt = 0;  ///< [ns]
	std::int64_t expiresAt = 0;   ///< time from which the command counts as zero [ns]
	ist::Wrench wrench;           ///< wrench on the hand, about the origin of H, in W
	double gripForce = 0;         ///< [N]
};

/// A haptic device. After open() no call allocates, blocks for longer than one period, or throws.
class Device
{
public:
	virtual ~Device() = default;

	virtual const DeviceInfo& info() const noexcept = 0;
	virtual DeviceStatus open() noexcept = 0;
	/// Leaves the device with zero force.
	virtual void close() noexcept = 0;
	/// Reads the newest sample. `now` [ns] never decreases from call to call. `state` changes only if the result is Ok.
	virtual DeviceStatus read(std::int64_t now, DeviceState& state) noexcept = 0;
	/// Sets the command. The device exerts it until the next command or until it expires. The driver itself then sets the force to zero,
	/// even if no further call comes.
	virtual DeviceStatus write(const DeviceCommand& command) noexcept = 0;
	/// Joints of the hand in the sample of the last read(). Returns false and leaves `hand` unchanged if the device senses none.
	virtual bool readHand(HandState&) noexcept { return false; }
	/// A sentence that says why open() failed or why the device was lost; empty if there is no reason. Do not call it in a tick, because it
	/// allocates and may wait.
	virtual std::string complaint() const { return {}; }
};
}  // namespace devicebridge
