// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Bullet/BulletHandSource.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "tests/unit/CountingAllocator.h"
#include "tests/unit/DeviceBridge/Hand/LightHand.h"
#include "tests/unit/KeptTree.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btStaticPlaneShape.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr double kStep = 1e-3, kRadius = 0.02;
constexpr bool kDouble = sizeof(btScalar) == 8;

std::shared_ptr<const ist::InnerSphereTree> ballTree()
{
	static const auto tree = keptTree(ist::makeSphereMesh(kRadius, 3), "ball_20mm.ist");
	return tree;
}

struct Rig
{
	btISTWorld world;
	btSphereShape ball{btScalar(kRadius)};
	btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
	btISTAttachment attachment = std::move(world.attach(&ball, ballTree())).value();
	std::vector<std::unique_ptr<btRigidBody>> bodies;

	~Rig()
	{
		for (auto& body : bodies) world.bullet().removeRigidBody(body.get());
	}
	btRigidBody& add(btCollisionShape& shape, double mass, const Vec3& at)
	{
		btVector3 inertia(0, 0, 0);
		if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
		bodies.push_back(std::make_unique<btRigidBody>(btScalar(mass), nullptr, &shape, inertia));
		btRigidBody& body = *bodies.back();
		body.setWorldTransform(btTransform(btQuaternion::getIdentity(), toBullet(at)));
		body.setInterpolationWorldTransform(body.getWorldTransform());
		body.setActivationState(DISABLE_DEACTIVATION);
		EXPECT_FALSE(world.materials().set(&body, {2e7, 2}));
		world.bullet().addRigidBody(&body);
		return body;
	}
};

BulletToolSettings settings(bool isStatic)
{
	BulletToolSettings s;
	s.gains = {1000, 0.2, 2, 1e-4, 100, 10, isStatic};
	return s;
}

void clear(ToolStep& step)
{
	step.contactCount = 0;
	step.overlapVolume = 0;
	step.pairs = 0;
}

DeviceState handAt(const Vec3& position)
{
	DeviceState hand;
	hand.X_WH.translation = position;
	return hand;
}

/// A device whose readHand() gives `joints`.
class Tracker final : public Device
{
public:
	DeviceInfo description;
	HandState joints;
	const DeviceInfo& info() const noexcept override { return description; }
	DeviceStatus open() noexcept override { return DeviceStatus::Ok; }
	void close() noexcept override {}
	DeviceStatus read(std::int64_t, DeviceState&) noexcept override { return DeviceStatus::Ok; }
	DeviceStatus write(const DeviceCommand&) noexcept override { return DeviceStatus::Ok; }
	bool readHand(HandState& hand) noexcept override
	{
		hand = joints;
		return true;
	}
};

HandState joints(const HandPosture& posture, const Vec3& place)
{
	HandPosture p = posture;
	p.X_WR.translation = place;
	return posedHand(p, {false, 0.189});
}
}  // namespace

// Each of two hands presses its ball on the floor, one deeper than the other. Alone in a world of its own, each feels the same; and a third
// ball, which falls beside them, has fallen for as many steps as there were ticks.
TEST(SharedWorld, TwoHandsFeelWhatEachFeelsAloneAndTheWorldStepsOnceATick)
{
	for (const bool isStatic : {false, true})
	{
		const double from[2] = {-0.1, 0.1}, depth[2] = {0.004, 0.009};
		double alone[2] = {};
		for (const int hands : {1, 2})
			for (int only = 0; only < (hands == 1 ? 2 : 1); ++only)
			{
				Rig rig;
				rig.add(rig.plane, 0, {});
				btRigidBody& falling = rig.add(rig.ball, 0.1, {0, 50, 0});
				std::vector<std::unique_ptr<BulletContactSource>> sources;
				for (int i = 0; i < 2; ++i)
					if (hands == 2 || i == only)
						sources.push_back(std::make_unique<BulletContactSource>(
							rig.world, rig.add(rig.ball, 0.1, {from[i], kRadius, 0}), settings(isStatic)));
				ToolStep steps[2];
				constexpr int kTicks = 1500;
				for (int tick = 0; tick < kTicks; ++tick)
				{
					const auto hand = [&](size_t i) {
						const int which = hands == 2 ? int(i) : only;
						return handAt({from[which], kRadius - depth[which], 0});
					};
					for (size_t i = 0; i < sources.size(); ++i) sources[i]->prepare(kStep, hand(i));
					for (size_t i = 0; i < sources.size(); ++i) clear(steps[i]), sources[i]->advance(kStep, hand(i), steps[i]);
				}
				for (size_t i = 0; i < sources.size(); ++i)
				{
					const int which = hands == 2 ? int(i) : only;
					const double felt = -steps[i].coupling.force.y;
					EXPECT_EQ(steps[i].contactCount, 1);
					EXPECT_NEAR(steps[i].contacts[0].onTool.force.y, felt, 0.01 * felt);
					if (hands == 1) alone[which] = felt;
					else EXPECT_NEAR(felt, alone[which], (kDouble ? 1e-9 : 1e-4) * felt);
					EXPECT_GT(felt, 0.5);
				}
				EXPECT_NEAR(double(falling.getLinearVelocity().y()), -9.81 * kTicks * kStep, kDouble ? 1e-9 : 1e-3);
			}
	}
}

// A hand whose source the loop does not prepare, because its device has given no sample yet, does not keep the world from stepping.
TEST(SharedWorld, AHandWithoutASampleDoesNotHoldTheWorld)
{
	Rig rig;
	btRigidBody& falling = rig.add(rig.ball, 0.1, {0, 50, 0});
	BulletContactSource first(rig.world, rig.add(rig.ball, 0.1, {0, 0, 0}), settings(false));
	BulletContactSource second(rig.world, rig.add(rig.ball, 0.1, {1, 0, 0}), settings(false));
	ToolStep step;
	for (int tick = 0; tick < 100; ++tick)
	{
		second.prepare(kStep, handAt({1.01, 0, 0}));
		clear(step), second.advance(kStep, handAt({1.01, 0, 0}), step);
	}
	EXPECT_NEAR(double(falling.getLinearVelocity().y()), -9.81 * 0.1, 1e-4);
	EXPECT_GT(step.tool.X_WT.translation.x, 1.001);
}

namespace
{
/// A right hand whose bent fingers push a box that floats. The device's world is turned and displaced.
struct PushingHand
{
	Rig rig;
	btBoxShape shape{btVector3(btScalar(0.1), btScalar(0.02), btScalar(0.1))};
	btRigidBody* box = nullptr;
	Tracker tracker;
	ist::Pose X_BW{rotationMatrix(ist::quaternionFromRotationVector({0.3, -0.4, 0.5})), {1, 2, 3}};
	std::unique_ptr<BulletHand> hand;
	std::unique_ptr<BulletHandSource> source;
	DeviceState state;
	ToolStep step;

	PushingHand()
	{
		EXPECT_FALSE(rig.world.setGravity(btVector3(0, 0, 0)));
		hand = std::move(BulletHand::create(rig.world, lightHand(TREE_FOLDER), joints({}, {}))).value();
		box = &rig.add(shape, 0.4, {0, -0.06, -0.1});
		source = std::make_unique<BulletHandSource>(rig.world, *hand, tracker, X_BW);
	}
	void tick(double down)
	{
		tracker.joints = joints({}, {0, -down, 0});
		moveHand(tracker.joints, inverse(X_BW));
		clear(step);
		source->advance(kStep, state, step);
	}
};
}  // namespace

TEST(SharedWorld, ATrackedHandFeelsWhatItsPartsFeel)
{
	PushingHand h;
	double most = 0;
	for (int i = 0; i < 400; ++i)
	{
		const btVector3 before = h.box->getLinearVelocity();
		h.tick(0.1e-3 * i);
		const BulletHand::Touch touch = h.hand->touch(kStep);
		Vec3 sum;
		for (const Vec3& force : touch.force) sum += force;  // forces among the parts cancel
		if (touch.parts == 0) continue;
		ASSERT_EQ(h.step.contactCount, 1);
		const ToolContact& contact = h.step.contacts[0];
		EXPECT_EQ(contact.other, h.box);
		const Vec3 onHand = h.X_BW.rotation * contact.onTool.force;
		// Self contacts were left out of the step, and cancel in the sum of the parts.
		ASSERT_LT(norm(onHand - sum), 1e-3 * norm(sum) + 1e-6) << i;
		// Action equals reaction: the box has no other force on it.
		const Vec3 change = toVec3(h.box->getLinearVelocity() - before);
		EXPECT_LT(norm(0.4 / kStep * change + onHand), 1e-3 * norm(onHand) + (kDouble ? 1e-6 : 2e-2)) << i;
		EXPECT_GT((h.X_BW.rotation * contact.normal).y, 0.5) << i;
		EXPECT_EQ(h.step.pairs, contact.pairs) << i;
		EXPECT_NEAR(h.step.overlapVolume, contact.volume, 1e-9 * contact.volume) << i;
		most = std::max(most, norm(onHand));
	}
	EXPECT_GT(most, 0.5);
	const Vec3 palm = h.X_BW * h.step.tool.X_WT.translation;
	EXPECT_LT(distance(palm, toVec3(h.hand->body(kHandPart).getWorldTransform().getOrigin())), 1e-5);
}

TEST(SharedWorld, ATrackedHandWithoutASampleLetsGo)
{
	PushingHand h;
	for (int i = 0; i < 100; ++i) h.tick(0);
	EXPECT_EQ(h.hand->trackingMonitor().grip(), 1);
	h.state.flags &= ~std::uint32_t(kHandPresent);
	for (int i = 0; i < 1000; ++i) h.tick(0);
	EXPECT_EQ(h.hand->trackingMonitor().grip(), 0);
	EXPECT_EQ(h.hand->trackingMonitor().complaints().lost, 1000u);
	h.state.flags = kReady;
	for (int i = 0; i < 1000; ++i) h.tick(0);
	EXPECT_EQ(h.hand->trackingMonitor().grip(), 1);
}

TEST(SharedWorld, ATickOfATrackedHandDoesNotAllocateAfterWarmUp)
{
	PushingHand h;
	for (int i = 0; i < 400; ++i) h.tick(0.1e-3 * i);
	const long before = allocationCount();
	for (int i = 0; i < 50; ++i) h.tick(0.04);
	EXPECT_EQ(allocationCount() - before, 0);
}
