// SPDX-License-Identifier: Zlib
#include "TestSupport/TestScenes.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include <cmath>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>

namespace ist::test
{
namespace
{
constexpr double kGravity = 9.81;
constexpr double kPi = 3.14159265358979323846;
constexpr double kSettling = 6, kWatching = 2;  // numbers of swings; values that oscillate are averaged over whole swings
constexpr double kMoreThanFriction = 0.5;
constexpr int kTower = 5;
constexpr double kHeavier = 20;

/// The body under test, in the world of a scene.
struct Subject
{
	btRigidBody& body;
	double mass, volume;
	double size;   ///< edge of the cube with its volume [m]
	double swing;  ///< period of a pendulum with the length `size` [s]
};

Subject make(const BodyMaker& maker, TestWorld& world, const btTransform& pose)
{
	btRigidBody& body = maker(world, pose);
	const auto tree = world.world().registration().registry().find(body.getCollisionShape());
	if (!tree) throw std::runtime_error("a scene needs a body with a tree: one of TestWorld::addMesh, addMeshFile or addAsset");
	if (body.isStaticOrKinematicObject()) throw std::runtime_error("a scene needs a body that moves: give it a mass");
	body.setDamping(0, 0);
	const double size = std::cbrt(tree->volume);
	return {body, 1 / double(body.getInvMass()), tree->volume, size, 2 * kPi * std::sqrt(size / kGravity)};
}

/// Makes the body with its lowest point at `height`, and then raises `height` to its highest point. The body is rotated about the
/// vertical, so that it is not aligned with the axes of the world.
Subject makeAbove(double& height, const BodyMaker& maker, TestWorld& world, double turn = 0.7)
{
	const Subject subject = make(maker, world, at(0, 0, 0, btVector3(0, 1, 0), turn));
	btVector3 lower, upper;
	subject.body.getAabb(lower, upper);
	subject.body.translate(btVector3(0, btScalar(height) - lower.y(), 0));
	subject.body.setInterpolationWorldTransform(subject.body.getWorldTransform());
	height += double(upper.y() - lower.y());
	return subject;
}

Subject makeOnFloor(const BodyMaker& maker, TestWorld& world)
{
	double height = 0;
	return makeAbove(height, maker, world);
}

/// Makes a tower on the floor. Each body is rotated against the one below it, and can only move up and down.
std::vector<Subject> makeTower(int count, const BodyMaker& maker, TestWorld& world)
{
	std::vector<Subject> tower;
	double height = 0;
	for (int i = 0; i < count; ++i)
	{
		tower.push_back(makeAbove(height, maker, world, 0.7 * (i + 1)));
		tower.back().body.setLinearFactor(btVector3(0, 1, 0));
		tower.back().body.setAngularFactor(btScalar(0));
	}
	return tower;
}

void makeHeavier(TestWorld& world, Subject& subject, double times)
{
	subject.mass *= times;
	const btVector3 acceleration = subject.body.getGravity();
	subject.body.setMassProps(btScalar(subject.mass), btScalar(times) * subject.body.getLocalInertia());
	subject.body.setGravity(acceleration);
	btContactMaterial material = world.world().materials().find(&subject.body);
	material.stiffness *= times;
	if (const auto refused = world.world().materials().set(&subject.body, material)) throw std::runtime_error(refused->message);
}

/// Force of the lower body on the upper one [N], averaged over the time since the last mark.
double meanForceUp(const TestWorld& world, const btRigidBody& upper, const btRigidBody& lower, double seconds)
{
	double sum = 0;
	for (const ContactRecord& record : world.log().records())
	{
		if (record.a == &upper && record.b == &lower) sum += record.impulseOnA.y;
		if (record.b == &upper && record.a == &lower) sum -= record.impulseOnA.y;
	}
	return sum / seconds;
}

/// Sum of the overlaps of the body with all others [m^3], averaged over the steps since the last mark.
double meanOverlap(const TestWorld& world, const btRigidBody& body, double seconds, double h)
{
	double sum = 0;
	for (const ContactRecord& record : world.log().records())
		if (record.a == &body || record.b == &body) sum += record.volume;
	return sum / double(std::lround(seconds / h));
}

double stiffnessOfContact(TestWorld& world)
{
	for (const btISTContact* contact : world.world().contacts().contacts())
		if (contact->patchCount > 0) return contact->constants.k;
	return std::numeric_limits<double>::quiet_NaN();
}

/// Lets the body come to rest. Returns the time for which it is watched after that [s].
double settle(TestWorld& world, double swing, double h)
{
	world.run(kSettling * swing, h);
	world.mark();
	const double begun = world.time();
	world.run(kWatching * swing, h);
	return world.time() - begun;
}

/// Mean overlap after the body has come to rest [m^3].
double overlapAtRest(TestWorld& world, const Subject& subject, double h)
{
	return meanOverlap(world, subject.body, settle(world, subject.swing, h), h);
}

/// Sends the second body towards the first one, which is at rest. Returns the time until they have met and parted [s].
double sendTowardsTheFirst(Subject (&subjects)[2], double speed)
{
	btVector3 centre;
	btScalar radius;
	subjects[1].body.getCollisionShape()->getBoundingSphere(centre, radius);
	btVector3 lower, upper;
	subjects[1].body.getAabb(lower, upper);
	// The offset is also limited to a share of the height: otherwise a plate would pass over the other body.
	const double off = 0.2 * std::fmin(subjects[1].size, double(upper.y() - lower.y()));
	subjects[1].body.translate(btVector3(2 * radius, btScalar(off), 0));
	subjects[1].body.setInterpolationWorldTransform(subjects[1].body.getWorldTransform());
	subjects[1].body.setLinearVelocity(btVector3(btScalar(-speed), 0, 0));
	return 4 * double(radius) / speed;
}
}  // namespace

double SceneValue::error() const { return std::fabs(measured - expected) / scale; }

std::ostream& operator<<(std::ostream& stream, const SceneValue& value)
{
	return stream << value.what << ": " << value.measured << ", expected " << value.expected << ", off by " << 100 * value.error() << " %";
}

std::vector<SceneValue> restOnFloor(const BodyMaker& body, double h)
{
	TestWorld world;
	world.addFloor().setFriction(1);
	const Subject subject = makeOnFloor(body, world);
	const double overlap = overlapAtRest(world, subject, h);
	const double expected = subject.mass * kGravity / stiffnessOfContact(world);
	return {{"overlap with the floor [m^3]", overlap, expected, expected},
		{"speed [m/s]", speed(subject.body), 0, std::sqrt(kGravity * subject.size)}};
}

std::vector<SceneValue> slideDownSlope(const BodyMaker& body, double h)
{
	TestWorld world;
	world.addFloor().setFriction(1);
	const Subject subject = makeOnFloor(body, world);
	subject.body.setAngularFactor(btScalar(0));
	const double angle = std::atan(double(subject.body.getFriction()) + kMoreThanFriction);
	// The slope is level, and gravity is inclined instead.
	world.world().setGravity(btVector3(btScalar(kGravity * std::sin(angle)), btScalar(-kGravity * std::cos(angle)), 0));
	world.run(subject.swing, h);
	const double before = double(subject.body.getLinearVelocity().x()), begun = world.time();
	world.run(kWatching * subject.swing, h);
	const double acceleration = (double(subject.body.getLinearVelocity().x()) - before) / (world.time() - begun);
	const double expected = kGravity * std::cos(angle) * kMoreThanFriction;
	return {{"acceleration down the slope [m/s^2]", acceleration, expected, expected}};
}

std::vector<SceneValue> floatInFluid(const BodyMaker& body, double h)
{
	TestWorld world;
	btRigidBody& surface = world.addFloor();
	surface.setFriction(0);
	// Upright, a body could stand in unstable balance and roll over while it is watched.
	const Subject subject = make(body, world, at(0, 0, 0, btVector3(btScalar(.1), 1, btScalar(.07)), 0.7));
	btContactMaterial fluid = btContactMaterial::fluid(2 * subject.mass / subject.volume);
	fluid.dissipation = 1 / std::sqrt(kGravity * subject.size);
	if (const auto refused = world.world().materials().set(&surface, fluid)) throw std::runtime_error(refused->message);
	const double overlap = overlapAtRest(world, subject, h), expected = subject.volume / 2;
	return {{"displaced volume [m^3]", overlap, expected, expected}};
}

std::vector<SceneValue> collideWithItsLike(const BodyMaker& body, double h)
{
	TestWorld world;
	world.world().setGravity(btVector3(0, 0, 0));
	Subject subjects[2] = {make(body, world, at(0, 0, 0)), make(body, world, at(0, 0, 0, btVector3(0, 1, 0), 0.7))};
	const double speed = 0.2 * std::sqrt(kGravity * subjects[0].size);
	const double seconds = sendTowardsTheFirst(subjects, speed);
	world.mark();
	world.run(seconds, h);
	const bool met = world.log().haveTouched(&subjects[0].body, &subjects[1].body);
	const double momentum = subjects[0].mass * speed, energy = momentum * speed / 2;
	return {{"meetings [1: they met]", double(met), 1, 1}, {"momentum from nowhere [N s]", norm(world.momentumFromNowhere()), 0, momentum},
		{"energy from nowhere [J]", larger(0, world.energyGained()), 0, energy}};
}

std::vector<SceneValue> standInTower(const BodyMaker& body, double h)
{
	TestWorld world;
	const btRigidBody& floor = world.addFloor();
	const std::vector<Subject> tower = makeTower(kTower, body, world);
	// The period of its slowest oscillation is at most that of a pendulum as long as the tower is high.
	const double seconds = settle(world, std::sqrt(double(kTower)) * tower[0].swing, h);
	std::vector<SceneValue> values = {{"speed [m/s]", world.fastest(), 0, std::sqrt(kGravity * tower[0].size)}};
	for (int i = 0; i < kTower; ++i)
	{
		const double carried = meanForceUp(world, tower[i].body, i == 0 ? floor : tower[i - 1].body, seconds);
		const double expected = (kTower - i) * tower[i].mass * kGravity;
		values.push_back({"force below number " + std::to_string(i + 1) + " from the floor [N]", carried, expected, expected});
	}
	return values;
}

std::vector<SceneValue> carryHeavyOne(const BodyMaker& body, double h)
{
	TestWorld world;
	const btRigidBody& floor = world.addFloor();
	std::vector<Subject> pair = makeTower(2, body, world);
	const Subject& light = pair[0];
	Subject& heavy = pair[1];
	makeHeavier(world, heavy, kHeavier);
	const double seconds = settle(world, std::sqrt(2) * light.swing, h);
	const double weight = heavy.mass * kGravity, both = weight + light.mass * kGravity;
	return {{"force below the heavy one [N]", meanForceUp(world, heavy.body, light.body, seconds), weight, weight},
		{"force below the light one [N]", meanForceUp(world, light.body, floor, seconds), both, both},
		{"speed [m/s]", world.fastest(), 0, std::sqrt(kGravity * light.size)}};
}

const std::vector<TestScene>& testScenes()
{
	static const std::vector<TestScene> scenes = {
		{"RestOnFloor", "the overlap times the stiffness of the contact is the weight, and nothing moves", restOnFloor},
		{"SlideDownSlope", "the acceleration is g (sin a - mu cos a)", slideDownSlope},
		{"FloatInFluid", "the displaced fluid weighs as much as the body: half of it is immersed", floatInFluid},
		{"StandInTower", "each of five carries those above it, and nothing moves", standInTower},
		{"CarryHeavyOne", "the light one carries the heavy one, the floor both, and nothing moves", carryHeavyOne},
		{"CollideWithItsLike", "momentum stays, and no energy is gained", collideWithItsLike},
	};
	return scenes;
}
}  // namespace ist::test
