// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "tests/unit/KeptTree.h"

#include <gtest/gtest.h>

#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <limits>

using namespace devicebridge;

namespace
{
constexpr double kRadius = 0.02, kStart = 0.03, kTarget = 0.012;  // radius of the ball, and heights of its centre [m]
constexpr double kPairStiffness = 1e7;                            // [Pa/m]
constexpr double kCoupling = 1500;                                // [N/m]
constexpr double kOwnWall = 900, kOwnHeight = 0.009;              // stiffness and height of the user's own hand [N/m, m]
constexpr double kOwnShare = 0.4;
constexpr int kTicks = 2500;

/// A user's own contacts: the hand itself against a spring below y = kRadius.
class OwnSource final : public ContactSource
{
public:
	void advance(double, const DeviceState& hand, ToolStep& step) noexcept override
	{
		step.tool = {hand.X_WH, hand.twist};
		const double depth = std::max(0.0, kRadius - hand.X_WH.translation.y);
		step.coupling = {{0, -kOwnWall * depth, 0}, {}};
		if (depth == 0) return;
		step.contactCount = 1;
		step.contacts[0] = {{{0, kOwnWall * depth, 0}, {}}, hand.X_WH.translation, {0, 1, 0}, 1e-9, 1, this};
	}
};

/// A user's own force law.
class OwnLaw final : public ForceLaw
{
public:
	ist::Wrench handWrench(const DeviceState&, const ToolStep& step) noexcept override { return -kOwnShare * step.coupling; }
};

/// A user's own device: a hand that moves down and stays there, whatever it feels.
class OwnDevice final : public Device
{
public:
	DeviceCommand last;
	int reads = 0, writes = 0;
	const DeviceInfo& info() const noexcept override { return m_info; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		state = {};
		state.sequence = static_cast<std::uint64_t>(++reads);
		state.sampledAt = now;
		const double way = std::min(1.0, reads / 1000.0);
		state.X_WH.translation.y = kStart + way * (kOwnHeight - kStart);
		if (way < 1) state.twist.linear.y = (kOwnHeight - kStart) / 1.0;
		return DeviceStatus::Ok;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		++writes;
		last = command;
		return DeviceStatus::Ok;
	}

private:
	DeviceInfo m_info = simulatedProfile("sigma7").value().info;
};

/// A ball as the tool, above Bullet's plane.
struct BallOnPlane
{
	btISTWorld world;
	btSphereShape ballShape{btScalar(kRadius)};
	btStaticPlaneShape planeShape{btVector3(0, 1, 0), 0};
	btRigidBody plane{0, nullptr, &planeShape};
	btRigidBody ball{btScalar(0.1), nullptr, &ballShape, btVector3(btScalar(1.6e-5), btScalar(1.6e-5), btScalar(1.6e-5))};
	btISTAttachment attachment;

	explicit BallOnPlane(double pairStiffness = kPairStiffness)
	{
		ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(kStart), 0)));
		// By its leaves, which are smooth: for a contact of 1e10 Pa/m and more the elements of a coarse ball are bumps.
		const auto leaves = std::make_shared<ist::InnerSphereTree>(*keptTree(ist::makeSphereMesh(kRadius, 3), "ball_20mm.ist"));
		leaves->surface = {};
		attachment = world.attach(&ballShape, leaves).value();
		world.materials().set(&ball, {2 * pairStiffness, 5});
		world.materials().set(&plane, {2 * pairStiffness, 5});
		world.bullet().addRigidBody(&plane);
		world.bullet().addRigidBody(&ball);
	}
	~BallOnPlane()
	{
		world.bullet().removeRigidBody(&ball);
		world.bullet().removeRigidBody(&plane);
	}
};

struct Modules
{
	bool source, law, device;  // whether each is the user's own
};
}  // namespace

// Each module is checked by its own condition at rest, whatever the others are.
TEST(ReplacedModules, EachModuleMayBeAUsersOwnAloneAndTogether)
{
	for (const Modules& own : {Modules{false, false, false}, {true, false, false}, {false, true, false}, {false, false, true},
			 {true, true, false}, {true, false, true}, {false, true, true}, {true, true, true}})
	{
		SCOPED_TRACE(std::string("own:") + (own.source ? " source" : "") + (own.law ? " law" : "") + (own.device ? " device" : ""));
		const SimulatedProfile profile = simulatedProfile("sigma7").value();
		SimulatedDevice ourDevice(profile);
		ourDevice.place({{}, {0, kStart, 0}});
		ourDevice.setHand(handThrough({{0, {{}, {0, kStart, 0}}}, {1, {{}, {0, kTarget, 0}}}}));
		ourDevice.open();
		OwnDevice ownDevice;
		BallOnPlane scene;
		BulletToolSettings settings;
		settings.gains = {kCoupling, 1, 0, 0, 12, 0.2};
		BulletContactSource ourSource(scene.world, scene.ball, settings);
		OwnSource ownSource;
		OwnLaw ownLaw;
		VirtualClock clock;
		Device& device = own.device ? static_cast<Device&>(ownDevice) : ourDevice;
		ContactSource& source = own.source ? static_cast<ContactSource&>(ownSource) : ourSource;
		SteppingThread thread(device, source, clock);
		if (own.law) thread.setForceLaw(&ownLaw);
		int touched = 0;
		thread.onCollision.addDelegate([&](const ToolContact& contact) {
			touched += contact.other == (own.source ? static_cast<const void*>(&ownSource) : &scene.plane);
		});
		ASSERT_TRUE(thread.run(kTicks));

		const double pull = -thread.step().coupling.force.y, sent = thread.sentWrench().force.y, height = thread.state().X_WH.translation.y;
		EXPECT_GT(pull, 1);
		EXPECT_GT(touched, kTicks / 3);
		// Law: the sent force is the law's share of the coupling.
		EXPECT_NEAR(sent, (own.law ? kOwnShare : 1) * pull, 0.01 * pull);
		// Source: a spring on the hand, or k V on the ball and the coupling between ball and hand.
		if (own.source) EXPECT_NEAR(pull, kOwnWall * (kRadius - height), 1e-9 * pull);
		else
		{
			EXPECT_NEAR(pull, kPairStiffness * thread.step().overlapVolume, 0.02 * pull);
			EXPECT_NEAR(pull, kCoupling * (thread.step().tool.X_WT.translation.y - height), 0.02 * pull);
		}
		// Device: a hand whose spring balances the force, or a device that accepts every command.
		if (own.device)
		{
			EXPECT_EQ(ownDevice.reads, kTicks);
			EXPECT_EQ(ownDevice.writes, kTicks);
			EXPECT_EQ(ownDevice.last.wrench.force.y, sent);
			EXPECT_NEAR(height, kOwnHeight, 1e-12);
		}
		else EXPECT_NEAR(sent, profile.handStiffness * (height - kTarget), 0.01 * pull);
	}
}

TEST(ReplacedModules, AUsersLawThatIsNotFiniteIsHeldBack)
{
	class Nonsense final : public ForceLaw
	{
	public:
		int calls = 0;
		ist::Wrench handWrench(const DeviceState&, const ToolStep& step) noexcept override
		{
			ist::Wrench wrench = -1.0 * step.coupling;
			if (++calls > 2000) wrench.torque.z = std::numeric_limits<double>::quiet_NaN();
			return wrench;
		}
	} law;
	OwnDevice device;
	BallOnPlane scene;
	BulletToolSettings settings;
	settings.gains = {kCoupling, 1, 0, 0, 12, 0.2};
	BulletContactSource source(scene.world, scene.ball, settings);
	VirtualClock clock;
	SteppingThread thread(device, source, clock);
	thread.setForceLaw(&law);
	thread.run(2000);
	EXPECT_GT(device.last.wrench.force.y, 1);
	thread.run(100);
	EXPECT_EQ(device.last.wrench.force, ist::Vec3());
	EXPECT_TRUE(thread.faulted());
	thread.setForceLaw(nullptr);
	thread.clearFault();
	thread.run(1000);
	EXPECT_FALSE(thread.faulted());
}

namespace
{
struct CoupledHand
{
	const char* profile;
	bool isStatic;
	double softContact;
};

/// Checks that a simulated hand that presses a ball on a plane comes to rest there, and feels its own spring.
void expectRest(const CoupledHand& coupled, double stiffness)
{
	SCOPED_TRACE(std::string(coupled.profile) + (coupled.isStatic ? ", static" : ", dynamic") + ", " + std::to_string(stiffness));
	const SimulatedProfile profile = simulatedProfile(coupled.profile).value();
	SimulatedDevice device(profile);
	device.place({{}, {0, kStart, 0}});
	device.setHand(handThrough({{0.6, {{}, {0, kStart, 0}}}, {0.8, {{}, {0, kTarget, 0}}}}));
	device.open();
	BallOnPlane scene(stiffness);
	if (coupled.softContact > 1) scene.ball.setFriction(0);
	BulletToolSettings settings;
	settings.gains = passiveGains(profile.info, profile.damping, profile.angularDamping, 1e-3);
	settings.gains.isStatic = coupled.isStatic;
	settings.gains.softContact = coupled.softContact;
	BulletContactSource source(scene.world, scene.ball, settings);
	VirtualClock clock;
	SteppingThread thread(device, source, clock);
	double low = 1e300, high = -1e300, taken = 0;  // energy dissipated by the mechanism [J]
	for (int i = 0; i < 3000; ++i)
	{
		const double from = device.truePose().translation.y;
		thread.run(1);
		const double way = device.truePose().translation.y - from;
		taken += profile.damping * way * way / 1e-3;
		if (i < 2500) continue;
		low = std::min(low, device.truePose().translation.y);
		high = std::max(high, device.truePose().translation.y);
	}
	EXPECT_LT(high - low, 5e-6);
	const double spring = profile.handStiffness * (high - kTarget);
	EXPECT_GT(spring, stiffness < 1e6 ? 1e-6 : 0.5);
	EXPECT_NEAR(thread.sentWrench().force.y, spring, 0.01 * spring + 1e-4);
	EXPECT_FALSE(thread.faulted());
	// Energy generated during landing and rest. The ramp comes first, because it stiffens a spring that is already pressed. The steps of a
	// coarse sensor simulate some energy. A tool without momentum chatters on a contact that yields by less than the resolution of single
	// precision. The mechanism must have dissipated all of it.
	const bool exact = !coupled.isStatic && profile.info.resolution < 1e-5 && stiffness >= 1e6;
	EXPECT_LT(thread.energy().generated, exact ? 1e-9 : taken);
}
}  // namespace

// The hand feels the coupling, however stiff the contact is: up to six decades beyond what direct rendering bears. This holds for devices
// with three and six degrees of freedom, for a tool with or without mass, and for an adapting coupling.
TEST(CoupledStiffness, ContactUpToATrillionPascalsPerMetreIsAtRest)
{
	for (const CoupledHand& coupled : {CoupledHand{"sigma7", false, 1}, CoupledHand{"sigma7", true, 1}, CoupledHand{"sigma7", true, 8},
			 CoupledHand{"touchx", false, 1}, CoupledHand{"touchx", true, 8}})
		for (const double stiffness : {1e2, 1e4, 1e6, 1e8, 1e10, 1e12}) expectRest(coupled, stiffness);
}
