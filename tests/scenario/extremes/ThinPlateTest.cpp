// SPDX-License-Identifier: Zlib
#include "demos/scenes/Extremes/ExtremeMotions.h"
#include "demos/scenes/Truth/PenetrationWork.h"
#include "tests/scenario/extremes/ExtremeTest.h"

using namespace extremes;

TEST(ThinPlate, LetsNothingThroughUnreported)
{
	const ExtremeSolid plate = solidOf(ist::makeBoxMesh({0.5, 0.0005, 0.5}), 2000);
	const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.05, 0.05, 0.05}), 300);
	int through = 0, held = 0, cautions = 0;
	for (const double speed : {0.01, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0})
		for (const double k : {1e6, 1e10})
		{
			const ShotOutcome shots = shootAtPlate(Response::Volumetric, plate, cube, speed, 1.0 / 60, k, 6);
			EXPECT_TRUE(shots.finite) << speed << " m/s, k " << k;
			EXPECT_EQ(shots.unreported, 0) << speed << " m/s, k " << k;
			through += shots.through;
			held += shots.held;
			cautions += shots.tooFast;
		}
	std::printf("  %d through, all reported; %d held, of which %d were too fast to be sure\n", through, held, cautions);
	EXPECT_GT(through, 20);
	EXPECT_GT(held, 0);
	EXPECT_LT(cautions, held);
}

namespace
{
/// True when a cube of 10 cm passes through a static plate. It flies face down, without dissipation and friction, in steps of 1/60 of the
/// thickness. The plate is soft and the cube rigid.
bool passes(const ExtremeSolid& plate, const ExtremeSolid& cube, double mass, double k, double thickness, double speed)
{
	ExtremeWorld world(Response::Volumetric, 0);
	btRigidBody* below = world.add(plate, 0, 0, transformOf({}), k);
	btRigidBody* body = world.add(cube, mass, mass / 600, transformOf({0.1, 0.08, -0.05}));
	EXPECT_FALSE(world.volumetric().materials().set(below, {k, 0}));
	body->setFriction(0);
	body->setLinearFactor(btVector3(0, 1, 0));
	body->setAngularFactor(btScalar(0));
	body->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
	const double h = thickness / (60 * speed);
	const auto height = [&] { return double(body->getWorldTransform().getOrigin().y()); };
	for (int i = 0; i < 4000 && height() < 0.085 && height() > -0.02; ++i) world.step(h);
	EXPECT_TRUE(height() > 0.085 || height() < -0.02) << height();
	return height() < 0;
}
}  // namespace

// The energy that the plate can stop is a property of material and thickness, predicted from the trees: m v^2 / 2 =
// penetrationWork().energy.
TEST(ThinPlate, LetsThroughWhatItsMaterialCannotHold)
{
	const double thickness = 0.01, mass = 2, k = 1e9;
	const ExtremeSolid plate = solidOf(ist::makeBoxMesh({0.3, thickness / 2, 0.3}), 4000),
					   cube = solidOf(ist::makeBoxMesh({0.05, 0.05, 0.05}), 500);
	ist::QueryWorkspace workspace;
	ist::Pose X_CP;
	X_CP.translation = {-0.1, -0.08, 0.05};
	const auto work = scenes::penetrationWork(*cube.tree, *plate.tree, X_CP, {0, -1, 0}, 0.1, {k, 0, 1}, workspace, 800);
	ASSERT_TRUE(work);
	const double limit = std::sqrt(2 * work.value().energy / mass);
	std::printf("  holds up to %.3f m/s and %.4g N\n", limit, work.value().force);
	EXPECT_FALSE(passes(plate, cube, mass, k, thickness, 0.98 * limit));
	EXPECT_TRUE(passes(plate, cube, mass, k, thickness, 1.05 * limit));
}
