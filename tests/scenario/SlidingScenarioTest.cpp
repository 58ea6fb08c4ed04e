// SPDX-License-Identifier: Zlib
#include "tests/scenario/VolumetricScene.h"
#include "tests/unit/BoredMesh.h"

#include <array>
#include <numbers>
#include <utility>

using namespace scenario;
using ist::Vec3;

namespace
{
constexpr double kGravity = 9.81;

const Solid& smallCube()
{
	static const Solid solid(ist::makeBoxMesh({0.1, 0.1, 0.1}), 1000);
	return solid;
}

/// A floor of 5 m with a wall of 4 m at its end, in one: an L, extruded along z. Its inner corner is at the origin, the floor at x < 0.
ist::Mesh floorWithWall()
{
	constexpr double kProfile[6][2] = {{0, 0}, {0, 4}, {0.4, 4}, {0.4, -0.4}, {-5, -0.4}, {-5, 0}};
	ist::Mesh mesh;
	for (const double z : {1.0, -1.0})
		for (const auto& [x, y] : kProfile) mesh.vertices.push_back({x, y, z});
	const auto addQuad = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
		mesh.triangles.push_back({a, b, c});
		mesh.triangles.push_back({a, c, d});
	};
	for (uint32_t i = 0; i < 6; ++i) addQuad(i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i);
	for (const uint32_t end : {0u, 6u})
		for (const auto& q : {std::array<uint32_t, 4>{0, 3, 2, 1}, {0, 5, 4, 3}})
			end == 0 ? addQuad(q[0], q[1], q[2], q[3]) : addQuad(6 + q[3], 6 + q[2], 6 + q[1], 6 + q[0]);
	return mesh;
}

double lowest(const Solid& solid, const Vec3& rotation)
{
	ist::Pose X;
	X.rotation = ist::rotationMatrix(ist::quaternionFromRotationVector(rotation));
	return lowestPoint(solid.mesh, X);
}

/// Speed along x after a second, of 1 m/s [m/s].
double speedAfter(Scene& scene, btRigidBody* body, double rate)
{
	scene.run(0.3, rate);
	body->setLinearVelocity(btVector3(1, body->getLinearVelocity().y(), body->getLinearVelocity().z()));
	scene.run(1, rate);
	return double(body->getLinearVelocity().x());
}
}  // namespace

// On slabs and on the box each of these stopped within a second, but for the face and edges along the way.
TEST(Sliding, WithoutFrictionNothingHoldsBack)
{
	enum class Floor
	{
		Plane,
		Box,
		SlabFirst,
		SlabLast
	};
	static const Solid slab(ist::makeBoxMesh({4, 0.2, 2}), 1000);
	const Vec3 corner = std::acos(1 / std::sqrt(3.0)) * ist::normalized({1, 0, -1});
	for (const double rate : {60.0, 240.0, 1000.0})
		for (const Floor kind : {Floor::Plane, Floor::Box, Floor::SlabFirst, Floor::SlabLast})
			for (const Vec3& turn : {Vec3{}, Vec3{0, 0, 0.785}, Vec3{0, 0, 0.26}, Vec3{0.785, 0, 0}, Vec3{0.3, 0.4, 0.5}, corner})
			{
				SCOPED_TRACE(testing::Message()
					<< "floor " << int(kind) << ", " << rate << " Hz, turned by " << turn.x << " " << turn.y << " " << turn.z);
				Scene scene;
				scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
				const auto addFloor = [&] {
					if (kind == Floor::Plane) return scene.addFloor();
					btCollisionShape* shape = kind == Floor::Box ? scene.shape<btBoxShape>(vec(Vec3{4, 0.2, 2}))
																 : scene.volumetricShape(slab);
					return scene.add(shape, 0, 0, at({0, -0.2, 0}));
				};
				if (kind != Floor::SlabLast) addFloor()->setFriction(0);
				btRigidBody* body = scene.add(scene.volumetricShape(smallCube()), 8, 0.05, at({-2, -lowest(smallCube(), turn), 0.1}, turn));
				if (kind == Floor::SlabLast) addFloor()->setFriction(0);
				body->setFriction(0);
				body->setAngularFactor(btScalar(0));
				EXPECT_NEAR(speedAfter(scene, body, rate), 1, 1e-3);
			}
}

namespace
{
constexpr double kPipe = 0.2, kSmall = 0.02, kSmallMass = 0.1;

/// Along z, so that a vertex of its cross-section is at the bottom, and what lies there touches two facets.
const Solid& pipe()
{
	static const Solid solid(boredMesh(kPipe, {0.25}, 0.3, 512), 3000);
	return solid;
}

const Solid& ball()
{
	static const Solid solid(ist::makeSphereMesh(kSmall, 4), 1000);
	return solid;
}

const Solid& dice()
{
	static const Solid solid(ist::makeBoxMesh({kSmall, kSmall, kSmall}), 1000);
	return solid;
}

/// Period of a body whose centre swings by `angle` around the axis of the pipe, `arm` below it [s]. `inertia` is that with which it turns,
/// over its mass and per turn around the axis [m^2].
double periodOf(double arm, double inertia, double angle)
{
	return 2 * std::numbers::pi * std::sqrt((arm * arm + inertia) / (arm * kGravity)) * (1 + angle * angle / 16);
}

struct Swing
{
	double highest = 0, at = 0;  ///< largest angle around the axis of the pipe [rad], and its time [s]
};

/// The swing that ends after so many periods.
Swing swingAfter(double periods, double period, Scene& scene, const btRigidBody* body, double rate)
{
	Swing swing;
	for (double time = 0; time < (periods + 0.25) * period;)
	{
		scene.step(1 / rate);
		time += 1 / rate;
		const Vec3 p = vec(body->getWorldTransform().getOrigin());
		const double angle = std::atan2(p.x, -p.y);
		if (time > (periods - 0.25) * period && angle > swing.highest) swing = {angle, time};
	}
	return swing;
}

/// Distance of the centre of a cube from the axis that stands with two edges on the inside of the pipe.
double onTwoEdges() { return std::sqrt(kPipe * kPipe - kSmall * kSmall) - kSmall; }
}  // namespace

// Without friction all of these keep their speed along a pipe. A ball lost up to 65 % of it within a second, a cube all.
TEST(Sliding, WithoutFrictionNothingHoldsBackAlongAPipe)
{
	struct Case
	{
		const char* name;
		const Solid& solid;
		Vec3 turn;
		double height;
	};
	const double onEdge = kSmall * std::sqrt(2.0), quarter = std::numbers::pi / 4;
	const Case cases[] = {{"ball", ball(), {}, kSmall - kPipe}, {"cube on two edges", dice(), {}, -onTwoEdges()},
		{"cube on an edge along the pipe", dice(), {0, 0, quarter}, onEdge - kPipe},
		{"cube on the ends of an edge across it", dice(), {quarter, 0, 0}, onEdge - std::sqrt(kPipe * kPipe - kSmall * kSmall)}};
	for (const Case& c : cases)
		for (const double rate : {60.0, 240.0, 1000.0})
		{
			SCOPED_TRACE(testing::Message() << c.name << ", " << rate << " Hz");
			Scene scene;
			scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
			scene.add(scene.volumetricShape(pipe()), 0, 0, at({}))->setFriction(0);
			btRigidBody* body = scene.add(
				scene.volumetricShape(c.solid), kSmallMass, 0.4 * kSmallMass * kSmall * kSmall, at({0, c.height, -0.2}, c.turn));
			body->setFriction(0);
			if (&c.solid == &dice()) body->setAngularFactor(btScalar(0));
			scene.run(0.3, rate);
			body->setLinearVelocity(btVector3(0, 0, btScalar(0.3)));
			scene.run(1, rate);
			EXPECT_NEAR(double(body->getLinearVelocity().z()) / 0.3, 1, 2e-3);
		}
}

// Around the pipe a body without friction swings as a pendulum. What it loses is at the kinks of the mesh and in the steps of 1/240 s: 2 %
// of its angle within a swing. A cube on its edges stopped within one.
TEST(Sliding, WithoutFrictionABodySwingsAroundAPipe)
{
	for (const bool isBall : {true, false})
	{
		SCOPED_TRACE(isBall ? "ball" : "cube");
		constexpr double kAngle = 0.5, kRate = 240;
		const double arm = isBall ? kPipe - kSmall : onTwoEdges();
		Scene scene;
		scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
		scene.add(scene.volumetricShape(pipe()), 0, 0, at({}))->setFriction(0);
		const double inertia = (isBall ? 0.4 : 2.0 / 3) * kSmallMass * kSmall * kSmall;
		btRigidBody* body = scene.add(scene.volumetricShape(isBall ? ball() : dice()), kSmallMass, inertia,
			at({arm * std::sin(kAngle), -arm * std::cos(kAngle), 0}, {0, 0, kAngle}));
		body->setFriction(0);
		// A ball does not turn, a cube turns as it swings.
		const double perMass = isBall ? 0 : inertia / kSmallMass;
		const double period = periodOf(arm, perMass, kAngle);
		const auto [highest, at] = swingAfter(1, period, scene, body, kRate);
		EXPECT_NEAR(at, period, 0.02 * period);
		EXPECT_GT(highest, 0.96 * kAngle);
		EXPECT_LT(highest, 1.001 * kAngle);
	}
}

// With nothing set, a wheel rolls to and fro in a pipe twice as wide, and a ball slides. The oracle is the pendulum's period and amplitude.
// A step that is implicit in the force that turns them back keeps 0.16 to 0.99 of the angle in these cases. What slides still leaves
// the pipe in steps of 1/60 s, and is pushed back.
TEST(Sliding, WithNothingSetWhatSwingsInAPipeKeepsItsAngle)
{
	struct Case
	{
		const char* name;
		const Solid& solid;
		double radius, inertia;  // [m, kg m^2]
		double friction, rate, kept;
	};
	static const Solid wheel(ist::makeCylinderMesh(0.1, 0.02, 256), 1000);
	const double ofBall = 0.4 * kSmallMass * kSmall * kSmall, ofWheel = 0.5 * kSmallMass * 0.1 * 0.1;
	const Case cases[] = {{"wheel", wheel, 0.1, ofWheel, 1, 60, 0.96}, {"wheel", wheel, 0.1, ofWheel, 1, 240, 0.98},
		{"wheel", wheel, 0.1, ofWheel, 1, 1000, 0.98}, {"ball", ball(), kSmall, ofBall, 1, 240, 0.98},
		{"ball", ball(), kSmall, ofBall, 1, 1000, 0.98}, {"ball that slides", ball(), kSmall, ofBall, 0, 60, 0.4},
		{"ball that slides", ball(), kSmall, ofBall, 0, 240, 0.98}, {"ball that slides", ball(), kSmall, ofBall, 0, 1000, 0.98}};
	for (const Case& c : cases)
	{
		SCOPED_TRACE(testing::Message() << c.name << ", " << c.rate << " Hz");
		constexpr double kAngle = 0.5;
		const double arm = kPipe - c.radius;
		Scene scene;
		scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
		scene.add(scene.volumetricShape(pipe()), 0, 0, at({}))->setFriction(btScalar(c.friction));
		btRigidBody* body = scene.add(
			scene.volumetricShape(c.solid), kSmallMass, c.inertia, at({arm * std::sin(kAngle), -arm * std::cos(kAngle), 0}));
		body->setFriction(btScalar(c.friction));
		const double turns = c.friction > 0 ? arm / c.radius : 0;  // per turn around the axis
		const double period = periodOf(arm, turns * turns * c.inertia / kSmallMass, kAngle);
		const auto [highest, at] = swingAfter(5, period, scene, body, c.rate);
		std::printf("  %s, %.0f Hz: %.3f of the angle after five periods, %.4f of the period\n", c.name, c.rate, highest / kAngle,
			at / (5 * period));
		EXPECT_NEAR(at, 5 * period, 0.05 * period);
		EXPECT_GT(highest, c.kept * kAngle);
		EXPECT_LT(highest, 1.01 * kAngle);
	}
}

// A ladder leans on a wall with the same friction as the floor's: it slips where tan(angle) < (1 - mu^2) / (2 mu).
// Where floor and wall are one body, each part of the contact is flat for itself.
TEST(Sliding, ALadderSlipsAtItsAngle)
{
	static const Solid floor(ist::makeBoxMesh({4, 0.2, 1}), 1000), wall(ist::makeBoxMesh({0.2, 3, 1}), 1000), both(floorWithWall(), 1000),
		ladder(ist::makeBoxMesh({1.5, 0.025, 0.2}), 1000);
	static const Vec3 middle = ist::massProperties(floorWithWall()).centerOfMass;
	for (const double friction : {0.3, 0.5})
		for (const double share : {0.96, 1.04})
			for (const auto& [rate, isOne] : {std::pair{60.0, false}, {240.0, false}, {60.0, true}, {240.0, true}})
			{
				SCOPED_TRACE(testing::Message() << (isOne ? "one body, friction " : "friction ") << friction << ", " << share
												<< " of the angle from the wall, " << rate << " Hz");
				const double critical = std::atan((1 - friction * friction) / (2 * friction));
				const double angle = std::numbers::pi / 2 - share * (std::numbers::pi / 2 - critical), c = std::cos(angle),
							 s = std::sin(angle);
				const Vec3 foot{-1.5 * c + 0.025 * s, -1.5 * s - 0.025 * c, 0}, head{1.5 * c + 0.025 * s, 1.5 * s - 0.025 * c, 0};
				Scene scene;
				scene.world.setGravity(btVector3(0, btScalar(-kGravity), 0));
				const double corner = head.x - foot.x;
				if (isOne) scene.add(scene.volumetricShape(both), 0, 0, at(middle + Vec3{corner, 0, 0}))->setFriction(1);
				else
				{
					scene.add(scene.volumetricShape(floor), 0, 0, at({0, -0.2, 0}))->setFriction(1);
					scene.add(scene.volumetricShape(wall), 0, 0, at({corner + 0.2, 2, 0}))->setFriction(1);
				}
				btRigidBody* body = scene.add(scene.volumetricShape(ladder), 20, 15, at(-foot, {0, 0, angle}));
				body->setFriction(btScalar(friction));
				scene.run(2, rate);
				const double slid = norm(vec(body->getWorldTransform().getOrigin()) + foot);
				if (share < 1) EXPECT_LT(slid, 0.03);
				else EXPECT_GT(slid, 0.3);
			}
}
