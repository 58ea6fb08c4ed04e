// SPDX-License-Identifier: Zlib
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "DeviceBridge/Decorators/ClutchedDevice.h"
#include "DeviceBridge/Decorators/DelayedDevice.h"
#include "DeviceBridge/Decorators/LimitedDevice.h"
#include "DeviceBridge/Decorators/MountedDevice.h"
#include "DeviceBridge/Decorators/RecordingDevice.h"
#include "DeviceBridge/Decorators/VelocityFilter.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr std::int64_t kMs = 1'000'000;

ist::Mat3 turn(const Vec3& v) { return rotationMatrix(ist::quaternionFromRotationVector(v)); }

/// A device that reports what the test sets and stores its commands.
class Puppet final : public Device
{
public:
	DeviceInfo description = simulatedProfile("sigma7").value().info;
	DeviceState state;
	DeviceCommand last;
	HandState hand;
	DeviceStatus answer = DeviceStatus::Ok;  // result of write()
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& out) noexcept override
	{
		state.sequence++;
		state.sampledAt = now;
		out = state;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		last = command;
		return answer;
	}
	bool readHand(HandState& out) noexcept override
	{
		out = hand;
		return true;
	}
};

template <class Decorator, class... Args> std::pair<std::unique_ptr<Decorator>, Puppet*> decorated(Args... args)
{
	auto owned = std::make_unique<Puppet>();
	Puppet* puppet = owned.get();
	return {std::make_unique<Decorator>(std::move(owned), args...), puppet};
}

DeviceState readAt(Device& device, std::int64_t now)
{
	DeviceState state;
	EXPECT_EQ(device.read(now, state), DeviceStatus::Ok);
	return state;
}
}  // namespace

// Oracles: the same power on both sides of the mount, and a twist that is the derivative of the pose.
TEST(MountedDevice, KeepsPowerAndReportsTheDerivativeOfItsPose)
{
	std::mt19937_64 random(21);
	std::uniform_real_distribution<double> u(-1, 1);
	const auto any = [&](double size) { return Vec3{size * u(random), size * u(random), size * u(random)}; };
	for (int i = 0; i < 200; ++i)
	{
		const double scale = std::exp(2 * u(random));
		auto [device, puppet] = decorated<MountedDevice>(ist::Pose{turn(any(3)), i == 0 ? Vec3{1000, 0, 0} : any(1)}, scale);
		puppet->state.X_WH = {turn(any(3)), any(0.1)};
		puppet->state.twist = {any(1), any(5)};
		const DeviceState before = readAt(*device, 0);
		DeviceCommand command;
		command.wrench = {any(5), any(0.1)};
		device->write(command);
		const auto power = [](const ist::Wrench& w, const ist::Twist& v) { return dot(w.force, v.linear) + dot(w.torque, v.angular); };
		EXPECT_NEAR(power(puppet->last.wrench, puppet->state.twist), power(command.wrench, before.twist), 1e-9);

		const double h = 1e-6;
		puppet->state.X_WH.translation += h * puppet->state.twist.linear;
		puppet->state.X_WH.rotation = turn(h * puppet->state.twist.angular) * puppet->state.X_WH.rotation;
		const DeviceState after = readAt(*device, 1);
		EXPECT_NEAR(distance((after.X_WH.translation - before.X_WH.translation) / h, before.twist.linear), 0, 1e-5);
		const Vec3 turned = rotationVector(ist::quaternion(after.X_WH.rotation * transpose(before.X_WH.rotation))) / h;
		EXPECT_NEAR(distance(turned, before.twist.angular), 0, 1e-4);
	}
}

TEST(MountedDevice, ItsLimitsAreThoseFeltInTheWorld)
{
	const auto [device, puppet] = decorated<MountedDevice>(ist::Pose(), 4.0);
	const DeviceInfo &outer = device->info(), &own = puppet->description;
	// A world spring K pulls the handle at a displacement of 4 x with 4 * (K 4 x) = 16 K x.
	EXPECT_NEAR(16 * outer.maxStiffness, own.maxStiffness, 1e-9);
	EXPECT_NEAR(4 * outer.peakForce, own.peakForce, 1e-12);
	EXPECT_EQ(outer.workspaceRadius, 4 * own.workspaceRadius);
	EXPECT_EQ(outer.peakTorque, own.peakTorque);
}

TEST(ClutchedDevice, MovesOnlyTheHandleWhileOpen)
{
	auto [device, puppet] = decorated<ClutchedDevice>(2U);
	puppet->state.X_WH = {turn({0, 0, 0.5}), {0.01, 0, 0}};
	EXPECT_EQ(readAt(*device, 0).X_WH.translation, (Vec3{0.01, 0, 0}));
	puppet->state.buttons = 2;
	puppet->state.X_WH = {turn({0.3, 0, 0}), {0.05, 0.02, 0}};
	puppet->state.twist.linear = {1, 0, 0};
	const DeviceState open = readAt(*device, 1);
	EXPECT_NEAR(distance(open.X_WH.translation, {0.01, 0, 0}), 0, 1e-15);
	EXPECT_EQ(open.twist.linear, Vec3{});
	EXPECT_EQ(open.flags & kForcesEnabled, 0U);
	DeviceCommand command;
	command.wrench.force = {1, 2, 3};
	device->write(command);
	EXPECT_EQ(puppet->last.wrench.force, Vec3{});

	puppet->state.buttons = 0;
	const DeviceState closed = readAt(*device, 2);
	EXPECT_NEAR(distance(closed.X_WH.translation, {0.01, 0, 0}), 0, 1e-15);
	EXPECT_NEAR(norm(rotationVector(ist::quaternion(closed.X_WH.rotation * transpose(turn({0, 0, 0.5}))))), 0, 1e-12);
	puppet->state.X_WH.translation += Vec3{0, 0, 0.03};
	puppet->state.X_WH.rotation = turn({0, 0.2, 0}) * puppet->state.X_WH.rotation;
	const DeviceState moved = readAt(*device, 3);
	EXPECT_NEAR(distance(moved.X_WH.translation, {0.01, 0, 0.03}), 0, 1e-15);
	device->write(command);
	EXPECT_EQ(puppet->last.wrench.force, command.wrench.force);
}

// A loop reads into the sample of the tick before, so the flags of that sample must not stay.
TEST(ClutchedDevice, TheForceComesBackAfterTheClutchOnADeviceThatLeavesFlagsAsTheyAre)
{
	auto simulated = std::make_unique<SimulatedDevice>(simulatedProfile("sigma7").value());
	/// With a button.
	struct Buttoned final : DeviceDecorator
	{
		using DeviceDecorator::DeviceDecorator;
		bool pressed = false;
		DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
		{
			const DeviceStatus status = m_inner->read(now, state);
			state.buttons = pressed ? 1 : 0;
			return status;
		}
	};
	auto owned = std::make_unique<Buttoned>(std::move(simulated));
	Buttoned& button = *owned;
	ClutchedDevice device(std::move(owned), 1U);
	ASSERT_EQ(device.open(), DeviceStatus::Ok);
	DeviceState state;
	for (int i = 1; i <= 6; ++i)
	{
		button.pressed = i == 3;
		ASSERT_EQ(device.read(i * kMs, state), DeviceStatus::Ok);
		EXPECT_EQ(state.flags, i == 3 ? kReady & ~kForcesEnabled : kReady) << i;
	}
}

TEST(ClutchedDevice, NeitherHidesNorKeepsAPoseThatIsNone)
{
	auto [device, puppet] = decorated<ClutchedDevice>(1U);
	const ist::Pose good{turn({0, 0, 0.5}), {0.01, 0, 0}};
	puppet->state.X_WH = good;
	(void)readAt(*device, 0);
	puppet->state.X_WH.rotation.m[1][1] = 3;
	EXPECT_FALSE(isRigid(readAt(*device, 1).X_WH));
	puppet->state.buttons = 1;
	EXPECT_FALSE(isRigid(readAt(*device, 2).X_WH));
	puppet->state.X_WH = good;
	EXPECT_NEAR(distance(readAt(*device, 3).X_WH.translation, good.translation), 0, 1e-15);
	puppet->state.buttons = 0;
	const ist::Pose after = readAt(*device, 4).X_WH;
	EXPECT_NEAR(norm(rotationVector(ist::quaternion(after.rotation * transpose(good.rotation)))), 0, 1e-12);
}

// Oracles: the same power on both sides, and a twist that is the derivative of the pose, after clutches that rotated and shifted.
TEST(ClutchedDevice, KeepsPowerAndReportsTheDerivativeOfItsPose)
{
	std::mt19937_64 random(31);
	std::uniform_real_distribution<double> u(-1, 1);
	const auto any = [&](double size) { return Vec3{size * u(random), size * u(random), size * u(random)}; };
	auto [device, puppet] = decorated<ClutchedDevice>(1U);
	for (int i = 0; i < 200; ++i)
	{
		puppet->state.X_WH = {turn(any(3)), any(0.1)};
		puppet->state.buttons = 1;
		readAt(*device, 0);
		puppet->state.X_WH = {turn(any(3)), any(0.1)};
		const DeviceState stayed = readAt(*device, 0);
		puppet->state.buttons = 0;
		puppet->state.twist = {any(1), any(5)};
		const DeviceState before = readAt(*device, 0);
		EXPECT_LT(norm(rotationVector(ist::quaternion(before.X_WH.rotation * transpose(stayed.X_WH.rotation)))), 1e-7);
		DeviceCommand command;
		command.wrench = {any(5), any(0.1)};
		device->write(command);
		const auto power = [](const ist::Wrench& w, const ist::Twist& v) { return dot(w.force, v.linear) + dot(w.torque, v.angular); };
		EXPECT_NEAR(power(puppet->last.wrench, puppet->state.twist), power(command.wrench, before.twist), 1e-12);

		const double h = 1e-6;
		puppet->state.X_WH.translation += h * puppet->state.twist.linear;
		puppet->state.X_WH.rotation = turn(h * puppet->state.twist.angular) * puppet->state.X_WH.rotation;
		const DeviceState after = readAt(*device, 1);
		EXPECT_LT(distance((after.X_WH.translation - before.X_WH.translation) / h, before.twist.linear), 1e-5);
		EXPECT_LT(
			distance(rotationVector(ist::quaternion(after.X_WH.rotation * transpose(before.X_WH.rotation))) / h, before.twist.angular),
			1e-4);
	}
}

// A driver's axes are not exactly orthogonal; many clutches must not accumulate that error.
TEST(ClutchedDevice, StaysRigidOverManyClutches)
{
	std::mt19937_64 random(32);
	std::uniform_real_distribution<double> u(-1, 1);
	auto [device, puppet] = decorated<ClutchedDevice>(1U);
	for (int i = 0; i < 20000; ++i)
	{
		ist::Mat3 R = turn({3 * u(random), 3 * u(random), 3 * u(random)});
		for (int row = 0; row < 3; ++row)
			for (int column = 0; column < 3; ++column) R.m[row][column] *= 1 + 1e-6;
		puppet->state.X_WH.rotation = R;
		puppet->state.buttons = i & 1;
		ASSERT_TRUE(isRigid(readAt(*device, i).X_WH, 1e-5)) << i;
	}
}

TEST(VelocityFilter, ForgetsASampleThatIsNoNumber)
{
	for (const bool fromPositions : {false, true})
	{
		auto [device, puppet] = decorated<VelocityFilter>(20.0, fromPositions);
		device->open();
		readAt(*device, 0);
		for (double* broken : {&puppet->state.twist.linear.x, &puppet->state.X_WH.translation.y, &puppet->state.X_WH.rotation.m[0][0]})
		{
			const double good = *broken;
			*broken = std::numeric_limits<double>::quiet_NaN();
			DeviceState state;
			device->read(1 * kMs, state);
			EXPECT_FALSE(isFinite(state.twist) && isRigid(state.X_WH)) << "not hidden from those who judge";
			*broken = good;
			for (int i = 2; i < 5; ++i) EXPECT_TRUE(isFinite(readAt(*device, i * kMs).twist));
		}
	}
}

namespace
{
/// A device that knows its info only after open().
class LateDevice final : public Device
{
public:
	DeviceInfo known;
	const DeviceInfo& info() const noexcept override { return known; }
	DeviceStatus open() noexcept override
	{
		known.peakForce = 8;
		known.sensed = kHandJointsSensed;
		return DeviceStatus::Ok;
	}
	void close() noexcept override {}
	DeviceStatus read(std::int64_t, DeviceState&) noexcept override { return DeviceStatus::Ok; }
	DeviceStatus write(const DeviceCommand&) noexcept override { return DeviceStatus::Ok; }
	bool readHand(HandState&) noexcept override { return true; }
};
}  // namespace

TEST(Decorators, TakeWhatADeviceLearnsOfItselfWhenItIsOpened)
{
	MountedDevice mounted(std::make_unique<LateDevice>(), ist::Pose(), 2);
	RecordingDevice recorded(std::make_unique<LateDevice>(), 5);
	for (Device* device : {static_cast<Device*>(&mounted), static_cast<Device*>(&recorded)}) ASSERT_EQ(device->open(), DeviceStatus::Ok);
	EXPECT_EQ(mounted.info().peakForce, 4);
	readAt(recorded, 1);
	EXPECT_EQ(recorded.recording().info.peakForce, 8);
	EXPECT_EQ(recorded.recording().hands.size(), 1U);
}

TEST(VelocityFilter, FollowsAStepAsAnRCCircuit)
{
	auto [device, puppet] = decorated<VelocityFilter>(20.0, false);
	device->open();
	readAt(*device, 0);
	puppet->state.twist = {{1, 0, 0}, {0, 2, 0}};
	std::int64_t t = 0;
	std::mt19937_64 random(2);
	for (int i = 0; i < 50; ++i)
	{
		t += 500'000 + static_cast<std::int64_t>(random() % 1'000'000);
		const DeviceState s = readAt(*device, t);
		const double expected = 1 - std::exp(-2 * 3.14159265358979323846 * 20 * 1e-9 * static_cast<double>(t));
		EXPECT_NEAR(s.twist.linear.x, expected, 1e-12);
		EXPECT_NEAR(s.twist.angular.y, 2 * expected, 1e-12);
	}
}

TEST(VelocityFilter, DifferencesPositionsWhenAsked)
{
	auto [device, puppet] = decorated<VelocityFilter>(0.0, true);
	device->open();
	for (int i = 0; i < 20; ++i)
	{
		puppet->state.X_WH = {turn({0, 0, 2e-3 * i}), {0, 1000 + 0.5e-3 * i, 0}};
		const DeviceState s = readAt(*device, i * kMs);
		EXPECT_NEAR(s.twist.linear.y, i == 0 ? 0 : 0.5, 1e-9);
		EXPECT_NEAR(s.twist.angular.z, i == 0 ? 0 : 2, 1e-9);
		EXPECT_TRUE(s.velocityEstimated);
	}
}

TEST(DelayedDevice, StatesAndCommandsArriveLaterWithTheirOwnTimes)
{
	auto [device, puppet] = decorated<DelayedDevice>(3, 2);
	device->open();
	DeviceState state;
	for (int i = 0; i < 20; ++i)
	{
		puppet->state.X_WH.translation.x = i;
		const DeviceStatus status = device->read(i * kMs, state);
		ASSERT_EQ(status, i < 3 ? DeviceStatus::Disconnected : DeviceStatus::Ok);
		if (i >= 3)
		{
			EXPECT_EQ(state.X_WH.translation.x, i - 3);
			EXPECT_EQ(state.sampledAt, (i - 3) * kMs);
		}
		DeviceCommand command;
		command.computedAt = i * kMs;
		command.wrench.force.x = i;
		device->write(command);
		EXPECT_EQ(puppet->last.wrench.force.x, std::max(0, i - 2));
	}
}

TEST(DeviceDecorator, DecoratorsCompose)
{
	auto hand = std::make_unique<Puppet>();
	Puppet* puppet = hand.get();
	DelayedDevice device(
		std::make_unique<MountedDevice>(std::make_unique<VelocityFilter>(std::move(hand), 0.0), ist::Pose{{}, {0, 0, 1}}, 2.0), 1, 0);
	device.open();
	puppet->state.X_WH.translation = {0.1, 0, 0};
	DeviceState state;
	device.read(0, state);
	puppet->state.X_WH.translation = {9, 9, 9};
	ASSERT_EQ(device.read(kMs, state), DeviceStatus::Ok);
	EXPECT_EQ(state.X_WH.translation, (Vec3{0.2, 0, 1}));
	DeviceCommand command;
	command.wrench.force = {1, 0, 0};
	device.write(command);
	EXPECT_EQ(puppet->last.wrench.force, (Vec3{2, 0, 0}));
	EXPECT_EQ(device.info().model, puppet->description.model);
}

namespace
{
HandState anyHand(std::mt19937_64& random)
{
	std::normal_distribution<double> normal;
	HandState hand;
	for (HandJoint& joint : hand.joints)
	{
		joint = {{normal(random), normal(random), normal(random)},
			ist::quaternionFromRotationVector(Vec3{normal(random), normal(random), normal(random)}), 0.01, true};
	}
	return hand;
}
Vec3 fingertip(const HandJoint& joint, double ahead) { return joint.position + rotationMatrix(joint.orientation) * Vec3{0, 0, -ahead}; }
}  // namespace

TEST(Decorators, TheJointsOfAHandMoveWithItsHandle)
{
	std::mt19937_64 random(21);
	const ist::Pose X_WD{turn({0.3, -1, 0.5}), {1000, 2, -3}};
	auto [mounted, puppet] = decorated<MountedDevice>(X_WD, 2.0);
	puppet->hand = anyHand(random);
	puppet->state.X_WH = {rotationMatrix(puppet->hand.joints[kPalm].orientation), puppet->hand.joints[kPalm].position};
	DeviceState s;
	HandState hand;
	ASSERT_EQ(mounted->read(kMs, s), DeviceStatus::Ok);
	ASSERT_TRUE(mounted->readHand(hand));
	// The palm stays at the handle, and a point in front of a joint moves as the mount maps it.
	EXPECT_LT(distance(hand.joints[kPalm].position, s.X_WH.translation), 1e-9);
	for (std::size_t i = 0; i < hand.joints.size(); ++i)
	{
		const Vec3 own = fingertip(puppet->hand.joints[i], 0.02);
		EXPECT_LT(distance(fingertip(hand.joints[i], 0.04), X_WD.rotation * (2 * own) + X_WD.translation), 1e-9);
		EXPECT_NEAR(hand.joints[i].radius, 0.02, 1e-12);
	}

	auto [clutched, held] = decorated<ClutchedDevice>(1U);
	for (int i = 0; i < 6; ++i)
	{
		held->hand = anyHand(random);
		held->state.X_WH = {rotationMatrix(held->hand.joints[kPalm].orientation), held->hand.joints[kPalm].position};
		held->state.buttons = i == 2 || i == 3;
		ASSERT_EQ(clutched->read(i * kMs, s), DeviceStatus::Ok);
		ASSERT_TRUE(clutched->readHand(hand));
		EXPECT_LT(distance(hand.joints[kPalm].position, s.X_WH.translation), 1e-9);
		EXPECT_LT(norm(rotationVector(hand.joints[kPalm].orientation * conjugate(ist::quaternion(s.X_WH.rotation)))), 1e-9);
		for (std::size_t j = 1; j < hand.joints.size(); ++j)
		{
			const double own = distance(held->hand.joints[j].position, held->hand.joints[j - 1].position);
			EXPECT_NEAR(distance(hand.joints[j].position, hand.joints[j - 1].position), own, 1e-9);
		}
	}

	auto [delayed, late] = decorated<DelayedDevice>(2, 0);
	std::vector<Vec3> sent;
	for (int i = 0; i < 8; ++i)
	{
		late->hand = anyHand(random);
		sent.push_back(late->hand.joints[kIndexTip].position);
		const bool there = delayed->read(i * kMs, s) == DeviceStatus::Ok;
		EXPECT_EQ(there, delayed->readHand(hand));
		EXPECT_EQ(there, i >= 2);
		if (i >= 2)
		{
			EXPECT_EQ(hand.joints[kIndexTip].position, sent[static_cast<std::size_t>(i - 2)]);
		}
	}
}

TEST(LimitedDevice, NothingUnsafeReachesTheDevice)
{
	SafetySettings settings;
	settings.rampTime = 0;
	const auto [limited, puppet] = decorated<LimitedDevice>(settings);
	puppet->last.wrench.force = {99, 0, 0};
	DeviceCommand command;
	command.wrench.force = {100, 0, 0};
	ASSERT_EQ(limited->open(), DeviceStatus::Ok);
	// The force is zero before the first sample, and while the contact has lasted since the first sample.
	limited->write(command);
	EXPECT_EQ(puppet->last.wrench.force, Vec3());
	const double peak = puppet->description.peakForce;
	double last = 0;
	for (int i = 1; i <= 200; ++i)
	{
		readAt(*limited, i * kMs);
		command.computedAt = i * kMs;
		command.expiresAt = command.computedAt + 20 * kMs;
		command.wrench.force = {i < 50 || i > 60 ? 100.0 : 0.0, 0, 0};
		limited->write(command);
		const double force = puppet->last.wrench.force.x;
		ASSERT_EQ(force, limited->sentWrench().force.x);
		ASSERT_LE(force - last, peak / 20 + 1e-9) << i;
		ASSERT_LE(force, peak + 1e-9) << i;
		if (i <= 60)
		{
			ASSERT_EQ(force, 0) << i;
		}
		last = force;
	}
	EXPECT_GT(last, peak / 2);
	// Then follow a command that is already old, and one that is not finite.
	readAt(*limited, 230 * kMs);
	limited->write(command);
	EXPECT_EQ(puppet->last.wrench.force, Vec3());
	readAt(*limited, 231 * kMs);
	command.computedAt = 231 * kMs;
	command.expiresAt = 250 * kMs;
	command.wrench.force.y = std::numeric_limits<double>::quiet_NaN();
	limited->write(command);
	EXPECT_EQ(puppet->last.wrench.force, Vec3());
	EXPECT_TRUE(limited->limiter().faulted());
}

namespace
{
/// A device that is free for 20 ms and is then pushed with half the peak until `until` [ms]. Commands have a time `later` [ns] after the
/// read.
std::pair<std::unique_ptr<LimitedDevice>, Puppet*> pushed(int until, std::int64_t later)
{
	SafetySettings settings;
	settings.rampTime = 0;
	auto made = decorated<LimitedDevice>(settings);
	for (int i = 1; i <= until; ++i)
	{
		readAt(*made.first, i * kMs);
		DeviceCommand command;
		command.computedAt = i * kMs + later;
		command.expiresAt = command.computedAt + 20 * kMs;
		command.wrench.force.x = i > 20 ? 0.2 * made.second->description.peakForce : 0;
		made.first->write(command);
	}
	return made;
}
}  // namespace

// A loop may stamp its commands when they are finished, after it has read the device.
TEST(LimitedDevice, ACommandMayBeComputedAfterTheRead)
{
	for (const std::int64_t later : {std::int64_t(0), std::int64_t(300'000), 5 * kMs})
	{
		const auto [limited, puppet] = pushed(100, later);
		EXPECT_NEAR(puppet->last.wrench.force.x, 0.2 * puppet->description.peakForce, 1e-9) << later;
	}
	const auto [limited, puppet] = pushed(100, 1000 * kMs);
	EXPECT_EQ(puppet->last.wrench.force.x, 0);
}

// Oracle: force times displacement, for the forces that the device has accepted.
TEST(LimitedDevice, WhatTheDeviceRefusesDoesNoWork)
{
	const auto [limited, puppet] = pushed(100, 0);
	const double force = puppet->last.wrench.force.x, before = limited->limiter().energy().stored;
	DeviceCommand command;
	command.wrench.force.x = force;
	const auto move = [&, &limited = limited, &puppet = puppet](int ms) {
		puppet->state.X_WH.translation.x -= 1e-4;
		readAt(*limited, ms * kMs);
		command.computedAt = ms * kMs;
		command.expiresAt = command.computedAt + 20 * kMs;
		return limited->write(command);
	};
	puppet->answer = DeviceStatus::Disconnected;
	EXPECT_EQ(move(101), DeviceStatus::Disconnected);
	EXPECT_EQ(limited->sentWrench().force, Vec3());
	EXPECT_NEAR(limited->limiter().energy().stored - before, 1e-4 * force, 1e-12);
	puppet->answer = DeviceStatus::Ok;
	EXPECT_EQ(move(102), DeviceStatus::Ok);
	EXPECT_NEAR(limited->limiter().energy().stored - before, 1e-4 * force, 1e-12);
	EXPECT_EQ(limited->sentWrench().force, puppet->last.wrench.force);
	EXPECT_LE(limited->sentWrench().force.x, puppet->description.peakForce / 20 + 1e-9);
}
