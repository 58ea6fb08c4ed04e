// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"

#include "BulletDynamics/Vehicle/btRaycastVehicle.h"

#include <limits>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kMass = 2, kGravity = 9.81, kRate = 240;

/// A scene whose joints are destroyed before its bodies.
struct JointScene : Scene
{
	std::vector<std::unique_ptr<btTypedConstraint>> joints;
	btJointFeedback feedback;

	~JointScene()
	{
		for (auto& joint : joints) world.bullet().removeConstraint(joint.get());
	}
	template <class Joint, class... Arguments> Joint* join(Arguments&&... arguments)
	{
		joints.push_back(std::make_unique<Joint>(std::forward<Arguments>(arguments)...));
		joints.back()->setJointFeedback(&feedback);
		world.bullet().addConstraint(joints.back().get());
		return static_cast<Joint*>(joints.back().get());
	}
	/// Mean contact force on `body` over half a second [N].
	Vec3 meanForce(const btRigidBody* body)
	{
		Vec3 sum;
		const int steps = int(0.5 * kRate);
		for (int i = 0; i < steps; ++i)
		{
			step(1 / kRate);
			sum += impulseOn(world.contacts(), body);
		}
		return sum * (kRate / steps);
	}
};

/// A bar of 2 m on a hinge at its left end. It lies on a small ball below its right part, at the distance kLever from the hinge.
struct Lever : JointScene
{
	static constexpr double kLever = 1.7;
	btRigidBody* beam;
	btHingeConstraint* hinge;

	Lever()
	{
		const double ball = 0.15, depth = 0.02;
		add(shape<btSphereShape>(btScalar(ball)), 0, 0, at({5 + kLever - 1, 3 - 0.1 - ball + depth, -4}));
		beam = add(volumetricShape(bar()), kMass, 0.7, at({5, 3, -4}));
		setStiffness(beam, 1e7);
		hinge = join<btHingeConstraint>(*beam, btVector3(-1, 0, 0), btVector3(0, 0, 1));
	}
};
}  // namespace

// The ball's moment about the hinge is that of the weight. The hinge carries the rest of it. Friction may brace the beam between the two,
// by up to 0.25 of the force at a lever of 0.1 m, which changes the force itself by 1.5 %.
TEST(Joints, HingedBeamLeansOnABallAsTheLeverSays)
{
	Lever scene;
	scene.run(3, kRate);
	const double carried = scene.meanForce(scene.beam).y, expected = kMass * kGravity * 1 / Lever::kLever;
	EXPECT_NEAR(kRate * momentOn(scene.world.contacts(), scene.beam, {4, 3, -4}), kMass * kGravity * 1, 2e-4 * kMass * kGravity);
	EXPECT_NEAR(carried, expected, 0.02 * expected);
	const double reaction = double(scene.feedback.m_appliedForceBodyA.y());
	EXPECT_NEAR(reaction, kMass * kGravity - carried, 2e-3 * expected);
	EXPECT_LT(double(scene.beam->getAngularVelocity().length()), 1e-3);
}

// A motor at its limit adds its torque to that of the weight, or subtracts it. A positive torque lifts.
TEST(Joints, HingeMotorPressesWithItsTorque)
{
	for (const double torque : {12.0, -25.0})
	{
		Lever scene;
		scene.hinge->enableAngularMotor(true, btScalar(torque > 0 ? 100 : -100), btScalar(std::fabs(torque) / kRate));
		scene.run(3, kRate);
		const double expected = (kMass * kGravity - torque) / Lever::kLever;
		EXPECT_NEAR(scene.meanForce(scene.beam).y, expected, 0.01 * expected);
	}
}

// Without weight, a motor at its limit presses a cube against a wall with the motor's force.
TEST(Joints, SliderMotorPressesWithItsForce)
{
	JointScene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(cube());
	scene.add(shape, 0, 0, at({-2, 7, 3}));
	btRigidBody* cart = scene.add(shape, kMass, kMass / 6, at({-0.9, 7, 3}));
	scene.setStiffness(cart, 1e5);
	btTransform frame = btTransform::getIdentity();
	auto* slider = scene.join<btSliderConstraint>(*cart, frame, true);
	slider->setLowerLinLimit(-10);
	slider->setUpperLinLimit(10);
	slider->setPoweredLinMotor(true);
	slider->setTargetLinMotorVelocity(btScalar(-1));
	slider->setMaxLinMotorForce(btScalar(35));
	scene.run(4, kRate);
	const Vec3 force = scene.meanForce(cart);
	EXPECT_NEAR(force.x, 35, 0.35);
	EXPECT_LT(std::hypot(force.y, force.z), 0.05 * 35);  // the slider carries the error of the model's normal
	EXPECT_LT(double(cart->getLinearVelocity().length()), 1e-3);
}

// Hooke's law: the spring of a six-dof joint presses with its stiffness times its deviation from the rest length.
TEST(Joints, SpringOfASixDofJointPressesAsHookeSays)
{
	JointScene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(cube());
	scene.add(shape, 0, 0, at({4, 1, 0}));
	btRigidBody* body = scene.add(shape, kMass, kMass / 6, at({4, 2.1, 0}));
	scene.setStiffness(body, 1e5);
	auto* joint = scene.join<btGeneric6DofSpring2Constraint>(*body, btTransform::getIdentity());
	joint->setLinearLowerLimit(btVector3(0, -10, 0));
	joint->setLinearUpperLimit(btVector3(0, 10, 0));
	joint->setAngularLowerLimit(btVector3(0, 0, 0));
	joint->setAngularUpperLimit(btVector3(0, 0, 0));
	joint->enableSpring(1, true);
	joint->setStiffness(1, btScalar(120));
	joint->setDamping(1, btScalar(20));
	joint->setEquilibriumPoint();
	joint->setEquilibriumPoint(1, btScalar(-0.6));
	scene.run(8, kRate);
	const double missing = 0.6 - (2.1 - double(body->getWorldTransform().getOrigin().y()));
	ASSERT_GT(missing, 0.4);
	EXPECT_NEAR(scene.meanForce(body).y, 120 * missing, 0.01 * 120 * missing);
	EXPECT_LT(double(body->getAngularVelocity().length()), 1e-4);
}

// Bullet's row of the joint leads its other body to no number, too. What that one touches by volumes must not follow, nor what is jointed
// to it.
TEST(Joints, ABodyWithoutANumberDoesNotSpreadThroughContact)
{
	Scene scene;
	scene.world.setGravity(btVector3(0, 0, 0));
	btCollisionShape* shape = scene.volumetricShape(cube());
	std::vector<btRigidBody*> row;
	for (const double x : {-3., 0., 0.98, 4.}) row.push_back(scene.add(shape, 1, 0.2, at({x, 0, 0})));
	for (const btRigidBody* body : row) scene.setStiffness(body, 1e4);
	btPoint2PointConstraint left(*row[0], *row[1], btVector3(1.5, 0, 0), btVector3(-1.5, 0, 0)),
		right(*row[2], *row[3], btVector3(1.5, 0, 0), btVector3(-1.5, 0, 0));
	for (btTypedConstraint* joint : {&left, &right}) scene.world.bullet().addConstraint(joint, true);
	scene.step(1. / 60);
	ASSERT_GT(norm(impulseOn(scene.world.contacts(), row[2])), 0);
	row[0]->setLinearVelocity(btVector3(std::numeric_limits<btScalar>::quiet_NaN(), 0, 0));
	for (int i = 0; i < 3; ++i) scene.step(1. / 60);
	EXPECT_FALSE(ist::isFinite(vec(row[1]->getLinearVelocity()))) << "Bullet's joint spreads it";
	for (const btRigidBody* body : {row[2], row[3]})
		EXPECT_TRUE(ist::isFinite(vec(body->getWorldTransform().getOrigin())) && ist::isFinite(vec(body->getLinearVelocity())));
	for (btTypedConstraint* joint : {&left, &right}) scene.world.bullet().removeConstraint(joint);
}

// Impulses among two jointed bodies and a third one do not change the total momentum.
TEST(Joints, JointedPairHitByAThirdBodyKeepsTheMomentum)
{
	for (const bool anchoredAside : {false, true})
	{
		JointScene scene;
		scene.world.setGravity(btVector3(0, 0, 0));
		btCollisionShape* shape = scene.volumetricShape(cube());
		std::vector<btRigidBody*> bodies;
		for (const Vec3& p : {Vec3{6, 2, 1}, Vec3{6, 3.2, 1}, Vec3{4.5, 2.4, 1.2}})
			bodies.push_back(scene.add(shape, kMass, kMass / 6, at(p, {0, anchoredAside ? 0.3 : 0.0, 0})));
		for (btRigidBody* b : bodies) scene.setStiffness(b, 1e5);
		bodies[2]->setLinearVelocity(btVector3(3, 0, 0));
		scene.join<btPoint2PointConstraint>(*bodies[0], *bodies[1], btVector3(0, btScalar(0.6), 0), btVector3(0, btScalar(-0.6), 0));
		bool touched = false;
		for (int i = 0; i < int(2 * kRate); ++i)
		{
			scene.step(1 / kRate);
			touched |= norm(scene.storedImpulse()) > 0;
		}
		EXPECT_TRUE(touched);
		Vec3 momentum;
		double energy = 0;
		for (const btRigidBody* b : bodies)
		{
			momentum += kMass * vec(b->getLinearVelocity());
			energy += 0.5 * kMass * double(b->getLinearVelocity().length2()) + 0.5 * kMass / 6 * double(b->getAngularVelocity().length2());
		}
		EXPECT_LT(norm(momentum - Vec3{3 * kMass, 0, 0}), kDouble ? 1e-9 : 1e-4);
		EXPECT_GT(double(bodies[1]->getLinearVelocity().length()), 0.05);  // the joint has transmitted the impulse
		EXPECT_LT(energy, 0.5 * kMass * 9 * 1.001);
	}
}

// A vehicle with ray-cast wheels: while the chassis touches nothing, the suspension carries its weight. Against a wall, the chassis
// presses with the driving force of the wheels.
TEST(Vehicle, ChassisWithATreePressesTheWallWithItsDrive)
{
	const Solid chassisSolid(ist::makeBoxMesh({0.8, 0.3, 1.5}), 500);
	JointScene scene;
	constexpr double kWeight = 400 * kGravity, kDrive = 600;
	scene.addFloor();
	btCollisionShape* wallShape = scene.volumetricShape(Solid(ist::makeBoxMesh({2, 1, 0.5}), 500));
	scene.add(wallShape, 0, 0, at({0, 1, 4}));
	btRigidBody* chassis = scene.add(scene.volumetricShape(chassisSolid), 400, 250, at({0, 1, 0}));
	scene.setStiffness(chassis, 1e6);
	btDefaultVehicleRaycaster caster(&scene.world.bullet());
	btRaycastVehicle::btVehicleTuning tuning;
	tuning.m_frictionSlip = 10;
	btRaycastVehicle vehicle(tuning, chassis, &caster);
	vehicle.setCoordinateSystem(0, 1, 2);
	for (const double x : {-0.7, 0.7})
		for (const double z : {-1.2, 1.2})
			vehicle.addWheel(btVector3(btScalar(x), btScalar(-0.1), btScalar(z)), btVector3(0, -1, 0), btVector3(-1, 0, 0), btScalar(0.4),
				btScalar(0.35), tuning, z > 0);
	for (int i = 0; i < vehicle.getNumWheels(); ++i)
	{
		btWheelInfo& w = vehicle.getWheelInfo(i);
		w.m_suspensionStiffness = 30;
		w.m_wheelsDampingRelaxation = w.m_wheelsDampingCompression = btScalar(6);
		w.m_rollInfluence = btScalar(0.1);
	}
	scene.world.bullet().addAction(&vehicle);
	scene.run(3, kRate);
	double carried = 0;
	for (int i = 0; i < vehicle.getNumWheels(); ++i) carried += double(vehicle.getWheelInfo(i).m_wheelsSuspensionForce);
	EXPECT_NEAR(carried, kWeight, 0.01 * kWeight);
	EXPECT_EQ(norm(scene.storedImpulse()), 0);
	for (int i = 0; i < vehicle.getNumWheels(); ++i) vehicle.applyEngineForce(btScalar(kDrive / 4), i);
	const double before = double(chassis->getWorldTransform().getOrigin().z());
	scene.run(6, kRate);
	const double z = double(chassis->getWorldTransform().getOrigin().z());
	EXPECT_GT(std::fabs(z - before), 1);
	EXPECT_LT(z, 2.1);  // not through the wall, whose face is at 3.5
	EXPECT_NEAR(norm(scene.meanForce(chassis)), kDrive, 0.05 * kDrive);
	scene.world.bullet().removeAction(&vehicle);
}

// A paddle that Bullet's linear factor holds, instead of a hinge, can still rotate. The angular momentum of paddle and cube about its
// centre is conserved, because the holding force acts there.
TEST(Joints, APaddleWithoutLinearFactorTurnsWhenItIsHit)
{
	constexpr double kCube = 1.5, kInertia = 0.25, kPaddle = 0.7, kSpeed = 1;
	const Vec3 pivot{5, 3, -4};
	for (const bool turns : {true, false})
	{
		Scene scene;
		scene.world.bullet().setGravity(btVector3(0, 0, 0));
		btRigidBody* paddle = scene.add(scene.volumetricShape(bar()), kMass, kPaddle, at(pivot));
		paddle->setLinearFactor(btVector3(0, 0, 0));
		paddle->setAngularFactor(btVector3(0, 0, btScalar(turns ? 1 : 0)));
		btRigidBody* cubeBody = scene.add(scene.volumetricShape(cube()), kCube, kInertia, at(pivot + Vec3{0.7, 0.605, 0.05}));
		cubeBody->setLinearVelocity(btVector3(0, btScalar(-kSpeed), 0));
		for (btRigidBody* body : {paddle, cubeBody}) scene.setStiffness(body, 1e6);
		const auto spin = [&] {
			const Vec3 arm = vec(cubeBody->getWorldTransform().getOrigin()) - pivot;
			return kCube * cross(arm, vec(cubeBody->getLinearVelocity())).z + kInertia * double(cubeBody->getAngularVelocity().z()) +
				kPaddle * double(paddle->getAngularVelocity().z());
		};
		const double before = spin();
		scene.run(0.2, kRate);
		const Vec3 turn = vec(paddle->getAngularVelocity());
		EXPECT_EQ(vec(paddle->getWorldTransform().getOrigin()), vec(at(pivot).getOrigin()));
		EXPECT_EQ(turn.x, 0);
		EXPECT_EQ(turn.y, 0);
		EXPECT_GT(double(cubeBody->getLinearVelocity().y()), -0.6 * kSpeed);
		if (turns)
		{
			EXPECT_LT(turn.z, -0.3);
			EXPECT_NEAR(spin(), before, 1e-4 * std::fabs(before));
		}
		else
		{
			EXPECT_EQ(turn.z, 0);
		}
	}
}
