// SPDX-License-Identifier: Zlib
// Sliding, rolling and sticking on a plane. The plane is level, and gravity is inclined.
#include "tests/bench/motion/MotionScene.h"

#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"

#include <algorithm>
#include <cmath>

using namespace ist;

namespace bench
{
namespace
{
constexpr double kPi = 3.14159265358979323846;

/// A ball slides on a slope until it rolls. `inertia`: over m R^2.
class RollingBall : public MotionScene
{
public:
	explicit RollingBall(double inertia) : m_inertia(inertia) {}
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		return add("ball", makeSphereMesh(kRadius, 5), 300, options);
	}
	Vec3 gravity() const override { return {kGravity * std::sin(kSlope), -kGravity * std::cos(kSlope), 0}; }
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 1);
		auto ball = bodySetup("ball", kMass, kFriction, isGiven, kStiffness, 0);
		ball.X_WM.translation = {0, kRadius - (isGiven ? depth() : 0), 0};
		btRigidBody* body = world.add(solid(0), std::move(ball));
		if (!body) return;
		const btScalar moment(m_inertia * kMass * kRadius * kRadius);
		body->setMassProps(btScalar(kMass), btVector3(moment, moment, moment));
		body->updateInertiaTensor();
		setVelocity(*body, {kSpeed, 0, 0});
	}
	std::optional<Pose> closedForm(size_t, double time) const override
	{
		const double along = kGravity * std::sin(kSlope), rubs = kFriction * kGravity * std::cos(kSlope);
		const double spinning = rubs / (m_inertia * kRadius), slows = along - rubs, rolls = kSpeed / (spinning * kRadius - slows);
		const double slid = std::min(time, rolls), rolled = time - slid, speed = kSpeed + slows * slid;
		const double x = kSpeed * slid + 0.5 * slows * slid * slid + speed * rolled + 0.5 * along / (1 + m_inertia) * rolled * rolled;
		const double angle = 0.5 * spinning * slid * slid + (speed * rolled + 0.5 * along / (1 + m_inertia) * rolled * rolled) / kRadius;
		Pose X;
		X.translation = {x, kRadius - depth(), 0};
		X.rotation = rotationMatrix(quaternionFromRotationVector({0, 0, -angle}));
		return X;
	}

private:
	static constexpr double kRadius = 0.1, kMass = 4, kSlope = 0.1, kFriction = 0.1, kSpeed = 1, kStiffness = 1e9;
	/// Depth of a ball at rest, whose cap below the plane is pi R depth^2.
	static double depth() { return std::sqrt(kMass * kGravity * std::cos(kSlope) / (kStiffness * kPi * kRadius)); }
	double m_inertia;
};

/// A block slides on a slope.
class SlidingBlock : public MotionScene
{
public:
	SlidingBlock(double slope, double friction, double speed) : m_slope(slope), m_friction(friction), m_speed(speed) {}
	std::optional<Error> prepare(const browser::DemoOptions& options) override { return add("block", makeBoxMesh(kHalf), 300, options); }
	Vec3 gravity() const override { return {kGravity * std::sin(m_slope), -kGravity * std::cos(m_slope), 0}; }
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 1);
		auto block = bodySetup("block", kMass, m_friction, isGiven, kStiffness, 5);
		block.X_WM.translation = {0, kHalf.y - (isGiven ? depth() : 0), 0};
		if (btRigidBody* body = world.add(solid(0), std::move(block))) setVelocity(*body, {m_speed, 0, 0});
	}
	std::optional<Pose> closedForm(size_t, double time) const override
	{
		const double a = kGravity * (std::sin(m_slope) - m_friction * std::cos(m_slope));
		const double moves = a < 0 ? std::min(time, m_speed / -a) : time;
		Pose X;
		X.translation = {m_speed * moves + 0.5 * a * moves * moves, kHalf.y - depth(), 0};
		return X;
	}

private:
	static constexpr Vec3 kHalf{0.15, 0.03, 0.1};
	static constexpr double kMass = 2, kStiffness = 1e7;
	double depth() const { return kMass * kGravity * std::cos(m_slope) / (kStiffness * 4 * kHalf.x * kHalf.z); }
	double m_slope, m_friction, m_speed;
};

/// A block lies on a belt, seen from the belt, and is pulled by a spring, whose other end moves to and fro.
class StickSlip : public MotionScene
{
public:
	std::optional<Error> prepare(const browser::DemoOptions& options) override
	{
		return add("block", makeBoxMesh({0.1, 0.03, 0.1}), 300, options);
	}
	void build(browser::DemoWorld& world, bool isGiven) override
	{
		world.addPlane({0, 1, 0}, 0, 1);
		auto block = bodySetup("block", 2, 0.3, isGiven, 1e7, 5);
		block.X_WM.translation = {0, 0.03, 0};
		m_body = world.add(solid(0), std::move(block));
	}
	void beforeStep(double time) override
	{
		const double stretch = 0.1 * std::sin(2 * kPi * time) - double(m_body->getWorldTransform().getOrigin().x());
		m_body->applyCentralForce(btVector3(btScalar(200 * stretch), 0, 0));
	}

private:
	btRigidBody* m_body = nullptr;
};

std::unique_ptr<MotionScene> makeBall() { return std::make_unique<RollingBall>(0.4); }
std::unique_ptr<MotionScene> makeHollowBall() { return std::make_unique<RollingBall>(2.0 / 3); }
std::unique_ptr<MotionScene> makeSlider() { return std::make_unique<SlidingBlock>(0.4, 0.3, 0); }
std::unique_ptr<MotionScene> makeStopper() { return std::make_unique<SlidingBlock>(0.15, 0.5, 1.5); }
std::unique_ptr<MotionScene> makeStickSlip() { return std::make_unique<StickSlip>(); }
}  // namespace

std::vector<MotionEntry> frictionScenes()
{
	return {{"rolling_ball", "A ball slides on a slope until it rolls", "Coulomb friction until the rim's speed is the ball's", 1.5, true,
				false, false, 61440, makeBall},
		{"hollow_ball", "The same with the inertia of a hollow ball", "the same", 1.5, true, false, false, 61440, makeHollowBall},
		{"sliding_block", "A block slides down a slope", "a = g (sin - mu cos)", 1, false, false, false, 61440, makeSlider},
		{"stopping_block", "A block slides on a slope until friction stops it", "a = g (sin - mu cos), until it is at rest", 1, true, false,
			false, 61440, makeStopper},
		{"stick_slip", "A block on a belt is pulled to and fro by a spring", nullptr, 2, true, false, false, 61440, makeStickSlip}};
}
}  // namespace bench
