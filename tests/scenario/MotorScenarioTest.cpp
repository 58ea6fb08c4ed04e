// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/CountingAllocator.h"

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kGravity = 9.81, kFinger = 0.1;

/// A scene whose joints are removed before its bodies. It has Bullet's ten iterations.
struct MotorScene : Scene
{
	std::vector<std::unique_ptr<btTypedConstraint>> joints;

	MotorScene() { EXPECT_EQ(world.bullet().getSolverInfo().m_numIterations, 10); }
	~MotorScene()
	{
		for (auto& joint : joints) world.bullet().removeConstraint(joint.get());
	}
	template <class Joint, class... Arguments> Joint* join(Arguments&&... arguments)
	{
		joints.push_back(std::make_unique<Joint>(std::forward<Arguments>(arguments)...));
		world.bullet().addConstraint(joints.back().get(), true);
		return static_cast<Joint*>(joints.back().get());
	}
	/// Lets a motor push `body` along -x.
	btSliderConstraint* push(btRigidBody& body, double speed, double force)
	{
		auto* slider = join<btSliderConstraint>(body, btTransform::getIdentity(), true);
		slider->setLowerLinLimit(-10);
		slider->setUpperLinLimit(10);
		slider->setPoweredLinMotor(true);
		slider->setTargetLinMotorVelocity(btScalar(-speed));
		slider->setMaxLinMotorForce(btScalar(force));
		return slider;
	}
	/// Contact force on `body` in the last step [N].
	Vec3 forceOn(const btRigidBody* body, double rate) { return rate * impulseOn(world.contacts(), body); }
};

const Solid& fingerSolid()
{
	static const Solid solid(ist::makeBoxMesh({0.01, 0.02, 0.03}), 500);
	return solid;
}

const Solid& blockSolid()
{
	static const Solid solid(ist::makeBoxMesh({0.05, 0.05, 0.05}), 500);
	return solid;
}

/// A finger beside a fixed block, which its motor presses in the direction of -x.
struct Finger : MotorScene
{
	static constexpr Vec3 kBlock{2, 1, -3};
	btRigidBody* finger;
	double rate;

	Finger(double stiffness, double hz) : rate(hz)
	{
		world.setGravity(btVector3(0, 0, 0));
		add(volumetricShape(blockSolid()), 0, 0, at(kBlock));
		finger = add(volumetricShape(fingerSolid()), kFinger, 1e-4, at(kBlock + Vec3{0.061, 0, 0}));
		if (stiffness > 0) setStiffness(finger, stiffness);
	}
};

struct SliderFinger : Finger
{
	btSliderConstraint* slider;

	SliderFinger(double stiffness, double hz, double force, double speed) : Finger(stiffness, hz), slider(push(*finger, speed, force)) {}
	double force() { return forceOn(finger, rate).x; }
	double speed() const { return double(finger->getLinearVelocity().x()); }
};
}  // namespace

TEST(Motors, SliderPressesWithItsForceAtTenIterations)
{
	for (const double k : {1e8, 0.0})
		for (const double force : {10.0, 40.0, 200.0})
			for (const double speed : {0.05, 0.5})
				for (const double hz : {60.0, 240.0})
				{
					SliderFinger scene(k, hz, force, speed);
					scene.run(1, hz);
					EXPECT_NEAR(scene.force(), force, 0.02 * force) << "k " << k << ", " << speed << " m/s, " << hz << " Hz";
					EXPECT_LT(std::fabs(scene.speed()), 0.02 * speed);
				}
}

// A finger that a motor closes on a ball stops there, although nothing has pressed before.
TEST(Motors, AreKnownBeforeTheyPress)
{
	static const Solid ball(ist::makeSphereMesh(0.03, 4), 500);
	constexpr double kSpeed = 0.05, kPivot = 0.06;
	for (const bool turns : {false, true})
		for (const double hz : {60.0, 240.0})
			for (const double force : {10.0, 40.0, 200.0})
			{
				MotorScene scene;
				scene.world.setGravity(btVector3(0, 0, 0));
				scene.add(scene.volumetricShape(ball), 0, 0, at({2, 1, -3}));
				btRigidBody* finger = scene.add(scene.volumetricShape(fingerSolid()), kFinger, 5e-5, at({2.045, 1, -3}));
				if (turns)
				{
					auto* hinge = scene.join<btHingeConstraint>(*finger, btVector3(0, btScalar(-kPivot), 0), btVector3(0, 0, 1));
					hinge->enableAngularMotor(true, btScalar(kSpeed / kPivot), btScalar(force * kPivot / hz));
				}
				else scene.push(*finger, kSpeed, force);
				double deepest = 0;
				for (int i = 0; i < int(hz); ++i)
				{
					scene.step(1 / hz);
					// The hinge leans the pad by the way, and its middle stays where it presses.
					deepest = std::max(deepest, 2.04 - double(finger->getWorldTransform().getOrigin().x()));
				}
				// Where the finger turns, friction along it has a moment about the hinge, too.
				const double pressed = turns ? std::fabs(hz * momentOn(scene.world.contacts(), finger, {2.045, 1 - kPivot, -3})) / kPivot
											 : scene.forceOn(finger, hz).x;
				EXPECT_NEAR(pressed, force, 0.02 * force) << turns << ' ' << hz << " Hz";
				EXPECT_LT(deepest, 1e-3) << turns << ' ' << hz << " Hz, " << force << " N";
				EXPECT_LT(2.04 - double(finger->getWorldTransform().getOrigin().x()), 2e-4)
					<< turns << ' ' << hz << " Hz, " << force << " N";
			}
}

namespace
{
/// The finger and the block in a game's own world, with a solver of the game's choice.
template <class Stock> double forceUnder()
{
	btDefaultCollisionConfiguration configuration;
	btCollisionDispatcher dispatcher(&configuration);
	btDbvtBroadphase broadphase;
	btISTRegistration registration = btISTCollisionAlgorithm::registerAlgorithm(&dispatcher, broadphase.getOverlappingPairCache());
	auto materials = std::make_shared<btContactMaterialTable>();
	registration.setPairRule(materials);
	Stock stock;
	btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &stock, &configuration);
	world.setGravity(btVector3(0, 0, 0));
	auto solver = installVolumetricSolver(world, registration);
	EXPECT_TRUE(solver);
	if (!solver) return 0;
	btBoxShape blockShape(btVector3(btScalar(0.05), btScalar(0.05), btScalar(0.05)));
	btBoxShape fingerShape(btVector3(btScalar(0.01), btScalar(0.02), btScalar(0.03)));
	auto first = registration.registry().attach(&blockShape, blockSolid().tree);
	auto second = registration.registry().attach(&fingerShape, fingerSolid().tree);
	EXPECT_TRUE(first && second);
	btRigidBody block(0, nullptr, &blockShape), finger(btScalar(kFinger), nullptr, &fingerShape, btVector3(1, 1, 1) * btScalar(1e-4));
	block.setWorldTransform(at({1, 0, 2}));
	finger.setWorldTransform(at({1.061, 0, 2}));
	finger.setActivationState(DISABLE_DEACTIVATION);
	EXPECT_FALSE(materials->set(&finger, {1e8, -1}));
	world.addRigidBody(&block);
	world.addRigidBody(&finger);
	btSliderConstraint slider(finger, btTransform::getIdentity(), true);
	slider.setLowerLinLimit(-10);
	slider.setUpperLinLimit(10);
	slider.setPoweredLinMotor(true);
	slider.setTargetLinMotorVelocity(btScalar(-0.05));
	slider.setMaxLinMotorForce(40);
	world.addConstraint(&slider);
	for (int i = 0; i < 60; ++i) world.stepSimulation(btScalar(1 / 60.0), 0);
	double force = 0;
	for (const btISTContact* c : registration.store().contacts()) force += 60 * c->normalImpulse;
	world.removeConstraint(&slider);
	world.removeRigidBody(&finger);
	world.removeRigidBody(&block);
	return force;
}
}  // namespace

TEST(Motors, EachSolverOfBulletPressesWithTheForce)
{
	EXPECT_NEAR(forceUnder<btSequentialImpulseConstraintSolver>(), 40, 0.8);
	EXPECT_NEAR(forceUnder<btNNCGConstraintSolver>(), 40, 0.8);
}

// The moment of the contact about the hinge balances the motor.
TEST(Motors, HingePressesWithItsTorqueAtTenIterations)
{
	for (const double hz : {60.0, 240.0})
	{
		constexpr double kTorque = 2.4;
		Finger scene(1e8, hz);
		auto* hinge = scene.join<btHingeConstraint>(*scene.finger, btVector3(0, btScalar(-0.06), 0), btVector3(0, 0, 1));
		hinge->enableAngularMotor(true, btScalar(0.1), btScalar(kTorque / hz));
		scene.run(1.5, hz);
		const double moment = hz * momentOn(scene.world.contacts(), scene.finger, Finger::kBlock + Vec3{0.061, -0.06, 0});
		EXPECT_NEAR(std::fabs(moment), kTorque, 0.02 * kTorque);
	}
}

// A motor that reverses leaves the surface with its speed, and one with less force presses with that, in the next steps.
TEST(Motors, ContactFollowsTheMotorAtOnce)
{
	for (const double hz : {60.0, 240.0})
	{
		SliderFinger scene(1e8, hz, 40, 0.05);
		scene.run(0.5, hz);
		scene.slider->setMaxLinMotorForce(btScalar(10));
		for (int i = 0; i < 5; ++i)
		{
			scene.step(1 / hz);
			EXPECT_LT(scene.force(), 1.02 * 40);
		}
		EXPECT_NEAR(scene.force(), 10, 0.2);
		scene.slider->setMaxLinMotorForce(btScalar(40));
		scene.slider->setTargetLinMotorVelocity(btScalar(0.05));
		for (int i = 0; i < 2; ++i) scene.step(1 / hz);
		EXPECT_NEAR(scene.speed(), 0.05, 0.001);
		scene.run(0.2, hz);
		EXPECT_EQ(scene.force(), 0);
	}
}

// Without its motor, a finger gets no more than the energy of the contact, F^2 / 2 k A.
TEST(Motors, SwitchedOffOrRemovedGivesNoKick)
{
	constexpr double kForce = 40, kArea = 0.04 * 0.06;
	for (const double hz : {60.0, 240.0})
		for (const bool removed : {false, true})
		{
			SliderFinger scene(1e8, hz, kForce, 0.05);
			scene.run(0.5, hz);
			if (removed) scene.world.bullet().removeConstraint(scene.slider);
			else scene.slider->setPoweredLinMotor(false);
			for (int i = 0; i < int(hz / 4); ++i)
			{
				scene.step(1 / hz);
				EXPECT_LT(0.5 * kFinger * scene.speed() * scene.speed(), 1.02 * kForce * kForce / (2 * 1e8 * kArea));
			}
			if (removed) scene.world.bullet().addConstraint(scene.slider, true);
			scene.slider->setPoweredLinMotor(true);
			scene.run(1, hz);
			EXPECT_NEAR(scene.force(), kForce, 0.02 * kForce);
		}
}

// A load hangs below a bar of a thousandth of its mass, which lies on two blocks.
TEST(Motors, AHeavyLoadHangsOnALightBar)
{
	static const Solid barSolid(ist::makeBoxMesh({0.06, 0.01, 0.01}), 500);
	constexpr double kBar = 0.02, kLoad = 20;
	for (const double hz : {60.0, 240.0})
		for (const double k : {1e8, 0.0})
		{
			MotorScene scene;
			btCollisionShape* block = scene.volumetricShape(blockSolid());
			for (const double x : {-0.09, 0.09}) scene.add(block, 0, 0, at({4 + x, 1, 2}));
			btRigidBody* bar = scene.add(scene.volumetricShape(barSolid), kBar, 2e-5, at({4, 1.06, 2}));
			btRigidBody* load = scene.add(scene.shape<btSphereShape>(btScalar(0.02)), kLoad, 0.2, at({4, 0.7, 2}));
			if (k > 0) scene.setStiffness(bar, k);
			const btVector3 above(0, btScalar(0.36), 0);
			scene.join<btPoint2PointConstraint>(*bar, *load, btVector3(0, 0, 0), above);
			double farthest = 0;
			for (int i = 0; i < int(2 * hz); ++i)
			{
				scene.step(1 / hz);
				const btVector3 apart = bar->getWorldTransform().getOrigin() - load->getWorldTransform() * above;
				farthest = std::max(farthest, double(apart.length()));
			}
			EXPECT_LT(farthest, 2e-4) << hz << " Hz, k " << k;
			EXPECT_NEAR(scene.forceOn(bar, hz).y, (kBar + kLoad) * kGravity, 0.02 * kLoad * kGravity) << hz << " Hz, k " << k;
			EXPECT_NEAR(height(bar), 1.06, 0.005);
			EXPECT_LT(double(load->getLinearVelocity().length()), 0.02);
		}
}

namespace
{
/// A chain of cubes on hinges. It swings from a fixed point against a block.
struct Chain : MotorScene
{
	static constexpr int kLinks = 4;
	static constexpr double kMass = 0.5, kInertia = 4e-4;
	std::vector<btRigidBody*> links;

	Chain()
	{
		btCollisionShape* shape = volumetricShape(blockSolid());
		add(shape, 0, 0, at({1.08, 2.5, 1}));
		for (int i = 0; i < kLinks; ++i)
		{
			links.push_back(add(shape, kMass, kInertia, at({0.9 - 0.12 * i, 3, 1})));
			setStiffness(links.back(), 1e7);
			const btVector3 pivot(btScalar(0.06), 0, 0), axis(0, 0, 1);
			if (i == 0) join<btHingeConstraint>(*links[0], pivot, axis);
			else join<btHingeConstraint>(*links[size_t(i)], *links[size_t(i) - 1], pivot, -pivot, axis, axis);
		}
	}
	double energy() const
	{
		double sum = 0;
		for (const btRigidBody* b : links)
			sum += kMass * (0.5 * double(b->getLinearVelocity().length2()) + kGravity * height(b)) +
				0.5 * kInertia * double(b->getAngularVelocity().length2());
		return sum;
	}
};
}  // namespace

TEST(Motors, AChainThatHitsABlockGainsNoEnergy)
{
	for (const double hz : {60.0, 240.0, 1000.0})
	{
		Chain scene;
		const double start = scene.energy(), swing = Chain::kLinks * Chain::kMass * kGravity * 0.3;
		bool hit = false;
		double before = start;
		for (int i = 0; i < int(4 * hz); ++i)
		{
			scene.step(1 / hz);
			const bool touches = norm(scene.storedImpulse()) > 0;
			hit |= touches;
			const double now = scene.energy();
			EXPECT_LT(now, start) << hz << " Hz, step " << i;
			// What remains is Bullet's correction of the errors that the swing has left in the joints.
			EXPECT_LT(touches ? now - before : 0, 0.02 * swing) << hz << " Hz, step " << i;
			before = now;
		}
		EXPECT_TRUE(hit);
	}
}

TEST(Motors, StepsAreTheSameInEachRun)
{
	btVector3 last[2];
	for (btVector3& p : last)
	{
		Chain scene;
		scene.run(3, 60);
		p = scene.links.back()->getWorldTransform().getOrigin();
	}
	for (int i = 0; i < 3; ++i) EXPECT_EQ(last[0][i], last[1][i]);
}

TEST(Motors, StepAllocatesNothingAfterWarmUp)
{
	SliderFinger scene(1e8, 240, 40, 0.05);
	scene.run(0.5, 240);
	const long before = allocationCount();
	scene.run(0.5, 240);
	EXPECT_EQ(allocationCount() - before, 0);
	EXPECT_GT(scene.force(), 0);
}
