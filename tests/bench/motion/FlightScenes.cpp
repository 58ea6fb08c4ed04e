// SPDX-License-Identifier: Zlib
// Free flight, bounces, and bodies that turn while they touch one plane.
#include "tests/bench/motion/MotionScene.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/ConstraintSolver/btHingeConstraint.h"

#include <cmath>

using namespace ist;

namespace bench
{
namespace
{
Mat3 turn(const Vec3& rotationVector) { return rotationMatrix(quaternionFromRotationVector(rotationVector)); }

/// A cube falls.
class FreeFall : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		return add("cube", makeBoxMesh({0.1, 0.1, 0.1}), 200, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override { world.add(solid(0), bodySetup("cube", 1, 0.5, isGiven, 1e7, 1)); }
	std::optional<Pose> closedForm(size_t, double time) const override
	{
		Pose X;
		X.translation = {0, -0.5 * kGravity * time * time, 0};
		return X;
	}
};

/// A ball bounces on a plane, and drifts sideways.
class BounceTrain : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override { return add("ball", makeSphereMesh(0.1, 4), 300, options); }
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 0.3);
		auto ball = bodySetup("ball", 1, 1, isGiven, 2e6, 0.3);
		ball.X_WM.translation = {0, 0.35, 0};
		if (btRigidBody* body = world.add(solid(0), std::move(ball))) setVelocity(*body, {0.3, 0, 0});
	}
};

/// A slender block stands on an edge and rocks from one edge to the other.
class RockingBlock : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override { return add("block", makeBoxMesh(kHalf), 300, options); }
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 1);
		auto block = bodySetup("block", 2, 1, isGiven, 1e8, 2);
		block.X_WM.rotation = turn({0, 0, -kTilt});
		block.X_WM.translation = {0, kHalf.y * std::cos(kTilt) + kHalf.x * std::sin(kTilt), 0};
		world.add(solid(0), std::move(block));
	}

private:
	static constexpr Vec3 kHalf{0.05, 0.2, 0.05};
	static constexpr double kTilt = 0.12;
};

/// A coin spins on its rim, and sinks as it does.
class SpinningCoin : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		return add("coin", makeCylinderMesh(kRadius, kHalf, 64), 300, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 1);
		auto coin = bodySetup("coin", 0.5, 0.4, isGiven, 1e9, 5);
		coin.X_WM.rotation = turn({kTilt, 0, 0});  // its axis along z, which `kTilt` turns towards the ground
		coin.X_WM.translation = {0, kRadius * std::cos(kTilt) + kHalf * std::sin(kTilt), 0};
		if (btRigidBody* body = world.add(solid(0), std::move(coin))) setVelocity(*body, {}, {0, 12, 0});
	}

private:
	static constexpr double kRadius = 0.05, kHalf = 0.004, kTilt = 0.35;
};

/// A ball on a rod swings against a box, again and again.
class Pendulum : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		return add("ball", makeSphereMesh(kRadius, 4), 300, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		browser::BodySetup wall = bodySetup("wall", 0, 0.3, isGiven, 0, -1);
		wall.X_WM.translation = {-0.1 - kRadius, -kArm, 0};
		world.addShape(std::make_unique<btBoxShape>(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1))), makeBoxMesh({0.1, 0.1, 0.1}),
			std::move(wall));
		auto ball = bodySetup("ball", 0.5, 0.3, isGiven, 1e7, 0.5);
		ball.X_WM.rotation = turn({0, 0, kAngle});
		ball.X_WM.translation = ball.X_WM.rotation * Vec3{0, -kArm, 0};
		btRigidBody* body = world.add(solid(0), std::move(ball));
		if (!body) return;
		world.addConstraint(std::make_unique<btHingeConstraint>(*body, btVector3(0, btScalar(kArm), 0), btVector3(0, 0, 1)));
	}

private:
	static constexpr double kRadius = 0.05, kArm = 0.3, kAngle = 1;
};

template <class Scene> std::unique_ptr<MotionScene> make() { return std::make_unique<Scene>(); }
}  // namespace

std::vector<MotionEntry> flightScenes()
{
	return {{"free_fall", "A cube falls for a second and touches nothing", "y = -g t^2 / 2", 1, false, true, false, 61440, make<FreeFall>},
		{"bounce_train", "A ball falls 25 cm, bounces and drifts", nullptr, 1, true, true, false, 61440, make<BounceTrain>},
		{"rocking_block", "A slender block rocks from edge to edge", nullptr, 1.2, true, false, false, 61440, make<RockingBlock>},
		{"spinning_coin", "A coin spins on its rim", nullptr, 0.8, false, false, false, 61440, make<SpinningCoin>},
		{"pendulum", "A ball on a hinge swings against a box of Bullet's", nullptr, 1, true, false, false, 61440, make<Pendulum>}};
}
}  // namespace bench
