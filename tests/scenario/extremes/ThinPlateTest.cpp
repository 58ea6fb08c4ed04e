// SPDX-License-Identifier: Zlib
#include "tests/scenario/extremes/ExtremeTest.h"

#include <random>

using namespace extremes;

namespace
{
struct Shot
{
	bool through = false, finite = true;
	bool reported = false;
};

/// A cube of 10 cm flies at a static plate of 1 m by 1 m by 1 mm, with a random lead, face, and side step.
Shot shootAtPlate(const ExtremeSolid& plate, double speed, double h, double k, uint64_t seed)
{
	static const ExtremeSolid cube = solidOf(ist::makeBoxMesh({0.05, 0.05, 0.05}), 300);
	std::mt19937_64 random(seed);
	std::uniform_real_distribution<double> u(0, 1);
	ExtremeWorld world(Response::Volumetric, 0);
	world.add(plate, 0, 0, transformOf({}), 2 * k);
	const double lead = 0.1 + speed * h * u(random);
	btRigidBody* body = world.add(cube, 1, 1.0 / 600, transformOf({0.3 * u(random), lead, 0.3 * u(random)}, {u(random), u(random), u(random)}), 2 * k);
	body->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
	// Far enough to be wholly on the other side if nothing held it.
	const int steps = int(std::ceil((lead + 0.2) / (speed * h)));
	for (int i = 0; i < steps; ++i)
		if (world.volumetric().step(h)) break;
	Shot shot;
	const double y = double(body->getWorldTransform().getOrigin().y());
	shot.finite = std::isfinite(y);
	shot.through = y < 0;
	shot.reported = world.volumetric().passingPairs() > 0 || world.volumetric().statistics().contactsTurnedOver > 0;
	return shot;
}
}  // namespace

TEST(ThinPlate, LetsNothingThroughUnreported)
{
	const ExtremeSolid plate = solidOf(ist::makeBoxMesh({0.5, 0.0005, 0.5}), 2000);
	int through = 0, held = 0, cautions = 0;
	for (const double speed : {0.01, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0})
		for (const double k : {1e6, 1e10})
			for (uint64_t seed = 0; seed < 6; ++seed)
			{
				const Shot shot = shootAtPlate(plate, speed, 1.0 / 60, k, seed);
				EXPECT_TRUE(shot.finite) << speed << " m/s, k " << k << ", " << seed;
				through += shot.through;
				held += !shot.through;
				cautions += !shot.through && shot.reported;
				EXPECT_TRUE(!shot.through || shot.reported) << speed << " m/s, k " << k << ", " << seed;
			}
	std::printf("  %d through, all reported; %d held, of which %d were too fast to be sure\n", through, held, cautions);
	EXPECT_GT(through, 20);
	EXPECT_GT(held, 0);
	EXPECT_LT(cautions, held);
}
